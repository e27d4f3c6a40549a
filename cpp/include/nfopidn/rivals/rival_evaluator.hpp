// L4. Costs of many candidates of a rival at once: in lanes those laws that have some, with exact
// gradients, and the others one by one.
#pragma once

#include <optional>

#include "nfopidn/rivals/rival_job.hpp"
#include "nfopidn/rivals/rivals.hpp"
#include "nfopidn/tuning/batch.hpp"

namespace nfopidn::rivals {

// The law of the lanes that a law is, if it is one.
inline std::optional<LaneLaw> lane_law(std::size_t law) {
  const std::string name = law_name(law);
  for (std::size_t i = 0; i < std::size(ChoiceNames<LaneLaw>::names); ++i) {
    if (name == ChoiceNames<LaneLaw>::names[i]) return static_cast<LaneLaw>(i);
  }
  return {};
}

// What the lanes are given of a candidate: see RivalJob::numbers.
template <class Number>
std::vector<Number> lane_numbers(const RivalDesign& design, const Model<double>& model,
                                 const std::vector<Number>& parameters) {
  const bool is_regulator = lane_law(design.law) == LaneLaw::lqr;
  LqrTolerances<Number> tolerance;
  const Number* next = parameters.data();
  if (is_regulator) next = take_parameters(next, tolerance);
  std::vector<Number> numbers(next, parameters.data() + parameters.size());
  if (!design.integral) numbers.resize(numbers.size() + 2, Number(0.0));
  if (is_regulator) {
    for (const LqrGains<Number>& gains : lqr_table(tolerance, model.peak_speed, model.dt)) {
      numbers.insert(numbers.end(), {gains.k_x, gains.k_y, gains.k_theta});
    }
  }
  return numbers;
}

// One scenario, many candidates of one law.
class RivalEvaluator {
 public:
  // The scenario must outlive this. The design's parameters do not matter.
  RivalEvaluator(const Scenario& scenario, RivalDesign design);

  void set_instruction_set(InstructionSet set);

  const PreparedRun& run() const { return run_; }
  const Model<double>& model() const { return model_; }
  bool has_lanes() const { return kernels_.rival_costs != nullptr; }
  bool has_gradient() const { return kernels_.rival_gradient != nullptr; }

  // numbers: [candidates][count] of lane_numbers(); costs and bounds: [candidates].
  void costs(const std::vector<double>& numbers, int first, int candidates, int count,
             double* costs, const double* bounds) const;
  // Of a law without lanes, by its parameters.
  double cost(const std::vector<double>& parameters) const {
    RivalDesign candidate = design_;
    candidate.parameters = parameters;
    return evaluate(run_, candidate);
  }

  // The cost, and its slopes in the directions in which the numbers change by slopes,
  // [directions][count].
  double gradient(const std::vector<double>& numbers, const double* slopes, int directions,
                  double* result) const;

 private:
  int table_size() const { return lqr_table_size(model_.peak_speed); }

  LoopInputs<double> lane_inputs() const {
    LoopInputs<double> inputs = run_.inputs();
    if (inputs.noise == nullptr) inputs.noise = calm_.data();
    return inputs;
  }

  RivalJob job(const LoopInputs<double>& inputs, const double* numbers, int count) const {
    RivalJob job = {};
    job.plant = &run_.plant;
    job.inputs = &inputs;
    job.start = &run_.start;
    job.model = model_;
    job.torque_limit = run_.limits.torque;
    job.speeds = design_.speeds;
    job.law = *lane_law(design_.law);
    job.numbers = numbers;
    job.number_count = count;
    job.table_size = table_size();
    job.table_spacing = lqr_spacing(model_.peak_speed);
    job.poll = run_.poll();
    return job;
  }

  RivalDesign design_;
  PreparedRun run_;
  Model<double> model_;
  std::vector<Heading<double>> headings_;  // of the reference
  std::vector<Measurement<double>> calm_;  // no noise, a sample each
  BatchKernels kernels_;
};

}  // namespace nfopidn::rivals

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn::rivals {

NFOPIDN_HOST RivalEvaluator::RivalEvaluator(const Scenario& scenario, RivalDesign design)
    : design_(std::move(design)), run_(prepare(scenario)), model_(model_of(design_, run_)) {
  headings_ = run_.reference_headings();
  if (run_.inputs().noise == nullptr) calm_.resize(run_.reference.size());
  set_instruction_set(best_instruction_set());
}

NFOPIDN_HOST void RivalEvaluator::set_instruction_set(InstructionSet set) {
  kernels_ = {};
  if (run_.encoders) return;
  const std::optional<LaneLaw> law = lane_law(design_.law);
  if (!law || (*law == LaneLaw::lqr && table_size() > most_table_entries)) return;
  kernels_ = batch_kernels(set);
}

NFOPIDN_HOST void RivalEvaluator::costs(const std::vector<double>& numbers, int first,
                                        int candidates, int count, double* costs,
                                        const double* bounds) const {
  const StandardArithmetic arithmetic;
  LoopInputs<double> inputs = lane_inputs();
  inputs.headings = headings_.data();
  RivalJob job = this->job(inputs, numbers.data() + std::ptrdiff_t{first} * count, count);
  job.candidates = candidates;
  job.costs = costs;
  job.bounds = bounds;
  kernels_.rival_costs(job);
}

NFOPIDN_HOST double RivalEvaluator::gradient(const std::vector<double>& numbers,
                                             const double* slopes, int directions,
                                             double* result) const {
  const StandardArithmetic arithmetic;
  double cost = 0;
  const LoopInputs<double> inputs = lane_inputs();
  RivalJob job = this->job(inputs, numbers.data(), static_cast<int>(numbers.size()));
  job.candidates = 1;
  job.costs = &cost;
  job.bounds = nullptr;
  kernels_.rival_gradient({job, slopes, directions, result});
  return cost;
}

}  // namespace nfopidn::rivals

#endif  // NFOPIDN_DEFINES_TUNING
