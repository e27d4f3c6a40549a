// The exported C beside the library's C++ in float, fed the same random samples. Prints a line a
// subject: its name, the comparisons made, and how many had other bits. law.hpp and the C headers
// are those that test_export_hardware.py exports; it also defines the robot and the sample time.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <random>

#include "eddie_hardware.h"
#include "eddie_reference.h"
#include "law.hpp"

namespace {

using namespace nfopidn;

std::mt19937 engine(17);
float draw(float size) { return size * (static_cast<float>(engine()) * 0x1p-31F - 1.0F); }
bool chance(int percent) { return static_cast<int>(engine() % 100) < percent; }

class Subject {
 public:
  explicit Subject(const char* name) : name_(name) {}
  ~Subject() { std::printf("%s %d %d\n", name_, compared_, differ_); }
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;
  void compare(float ours, float theirs) {
    ++compared_;
    if (std::memcmp(&ours, &theirs, sizeof ours) != 0) ++differ_;
  }
  template <class Ours, class Theirs>
  void compare_wheels(const Ours& ours, const Theirs& theirs) {
    compare(ours.left, theirs.left);
    compare(ours.right, theirs.right);
  }

 private:
  const char* name_;
  int compared_ = 0;
  int differ_ = 0;
};

#ifdef READS_TURN_RATE
constexpr bool reads_turn_rate = true;  // as a law with speed errors does
#else
constexpr bool reads_turn_rate = false;
#endif

float bad_number() {
  constexpr float choices[] = {std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::infinity(), -1e30F, 1.1e6F};
  return choices[engine() % 4];
}

struct Sample {
  Measurement<float> measured;
  ReferenceSample<float> reference;
  eddie_pose pose;
  eddie_reference wanted;

  explicit Sample(bool bad) {
    const float size = chance(20) ? 4.0F : 0.3F;
    measured = {draw(size), draw(size), draw(3 * size), 0, 0};
    reference = {draw(size), draw(size), draw(3 * size), draw(1),
                 draw(1),    draw(0.5F), draw(0.5F),     chance(50)};
    if (bad) {
      float* const numbers[] = {&measured.x,     &measured.y,         &measured.theta,
                                &reference.x,    &reference.y,        &reference.theta,
                                &reference.v,    &reference.tau_left, &reference.tau_right,
                                &reference.omega};
      *numbers[engine() % (reads_turn_rate ? 10 : 9)] = bad_number();
    }
    pose = {measured.x, measured.y, measured.theta};
    wanted = {reference.x,        reference.y,         reference.theta,  reference.v,
#ifdef READS_TURN_RATE
              reference.omega,
#endif
              reference.tau_left, reference.tau_right, reference.reverse};
  }
};

using Smooth = Bumpless<law::Law, float>;

// One operation between samples: the same on both sides.
void disturb(Guarded<Smooth, float>& guarded, Smooth& smooth, eddie_guarded& state,
             Subject& subject) {
  const Sample sample(chance(30));
  switch (engine() % 40) {
    case 0:
      guarded.reset();
      eddie_guarded_reset(&state);
      subject.compare_wheels(TorquePair<float>{0, 0}, state.output);
      break;
    case 1:
      guarded.reset_to(sample.measured, sample.reference);
      eddie_guarded_reset_to(&state, &sample.pose, &sample.wanted);
      break;
    case 2:
    case 3: {
      const eddie_torques last = {chance(90) ? draw(5) : bad_number(),
                                  chance(90) ? draw(5) : bad_number()};
      const int samples = static_cast<int>(engine() % 8) - 1;
      smooth.begin_from({last.left, last.right}, samples);
      eddie_begin_glide(&state, &last, samples);
      break;
    }
    default:
      break;
  }
}

void compare_guarded(Bridge bridge, const char* name) {
  Subject subject(name);
  law::Law running = law::controller;
  Smooth smooth(running, law::torque_limit);
  Guarded<Smooth, float> guarded(smooth, 3, bridge);
  eddie_guarded state;
  eddie_guarded_init(&state, 3, bridge == Bridge::hold ? EDDIE_BRIDGE_HOLD : EDDIE_BRIDGE_REPEAT);
  int bad_ones = 0;  // in a row, so that all of the faults come
  for (int k = 0; k < 20000; ++k) {
    disturb(guarded, smooth, state, subject);
    if (bad_ones == 0 && chance(10)) bad_ones = static_cast<int>(engine() % 6);
    const bool bad = bad_ones > 0;
    if (bad) --bad_ones;
    const Sample sample(bad);
    const bool missed = bad && chance(50);
    const auto ours =
        missed ? guarded.missed(sample.reference) : guarded.step(sample.measured, sample.reference);
    const auto theirs = missed ? eddie_missed(&state, &sample.wanted)
                               : eddie_guarded_step(&state, &sample.pose, &sample.wanted);
    subject.compare_wheels(ours, theirs);
    subject.compare(static_cast<float>(guarded.fault()), static_cast<float>(state.fault));
    subject.compare(smooth.gliding() ? 1 : 0, state.gliding > 0 ? 1 : 0);
    subject.compare_wheels(to_rep103(ours), eddie_to_rep103(theirs));
  }
}

void compare_start() {
  Subject subject("start");
  law::Law ours = law::controller;
  eddie_state theirs;
  eddie_init(&theirs);
  for (int k = 0; k < 2000; ++k) {
    const Sample sample(false);
    if (k % 7 == 0) {
      ours.reset_to(sample.measured, sample.reference);
      eddie_reset_to(&theirs, &sample.pose, &sample.wanted);
      subject.compare_wheels(ours.feedback(), theirs.feedback);
    }
    subject.compare_wheels(ours.step(sample.measured, sample.reference),
                           eddie_step(&theirs, &sample.pose, &sample.wanted));
  }
}

constexpr Robot<float> robot = {ROBOT_MASS, ROBOT_INERTIA, ROBOT_TRACK, ROBOT_RADIUS};

void compare_wheels() {
  Subject subject("wheels");
  State<float> ours = {};
  eddie_pose theirs = {};
  int moves[2] = {};  // refused, made
  for (int k = 0; k < 5000; ++k) {
    const auto before = static_cast<std::uint32_t>(engine());
    // As far as the counters tell forward from backward, and anywhere.
    constexpr std::uint32_t edges[] = {0x7FFF, 0x8000, 0x7FFFFFFF, 0x80000000};
    const auto any = static_cast<std::uint32_t>(engine() >> (engine() % 32));
    const std::uint32_t now = before + (k % 5 == 0 ? edges[engine() % 4] : any);
    subject.compare(rolled(before, now, 900.0F, robot.wheel_radius),
                    eddie_rolled(before, now, 900.0F));
    const auto first = static_cast<std::uint16_t>(before);
    const auto second = static_cast<std::uint16_t>(now);
    subject.compare(rolled(first, second, 360.5F, robot.wheel_radius),
                    eddie_rolled_16(first, second, 360.5F));
    const float size = k % 3 == 0 ? 2e-4F : k % 3 == 1 ? 0.2F : 9.0F;
    const float left = chance(98) ? draw(size) : bad_number();
    const float right = k % 11 == 0 ? left : draw(size);
    const bool moved = try_odometry(ours, left, right, robot.track_width, EDDIE_LONGEST_STEP);
    subject.compare(moved ? 1 : 0, static_cast<float>(eddie_odometry(&theirs, left, right)));
    moves[moved ? 1 : 0] += 1;
    subject.compare(ours.x, theirs.x);
    subject.compare(ours.y, theirs.y);
    subject.compare(ours.theta, theirs.theta);
  }
  subject.compare(moves[0] > 500 && moves[1] > 3000 ? 1 : 0, 1);
}

void compare_reference_torques() {
  Subject subject("torques");
  const FrictionFeedforward<float> friction = {FRICTION};
  for (int k = 0; k < 5000; ++k) {
    const float size = k % 2 == 0 ? 1.0F : 0.01F;
    const float v = draw(size);
    const float omega = draw(3 * size);
    const float acceleration = draw(2);
    const float angular = draw(9);
    subject.compare_wheels(reference_torques(robot, friction, v, omega, acceleration, angular),
                           eddie_reference_torques(v, omega, acceleration, angular));
  }
}

void compare_velocities(Subject& subject, const eddie_velocity_limits& limits) {
  VelocityOutput<float> ours(
      robot, SAMPLE_TIME,
      {limits.v, limits.omega, limits.acceleration, limits.angular_acceleration});
  eddie_velocity_output theirs;
  const VelocityLimits<float> same = {limits.v, limits.omega, limits.acceleration,
                                      limits.angular_acceleration};
  subject.compare(same.validate() == Status::ok ? 1 : 0,
                  static_cast<float>(eddie_velocity_init(&theirs, &limits)));
  for (int k = 0; k < 5000; ++k) {
    const eddie_torques torques = {chance(95) ? draw(3) : bad_number(),
                                   chance(95) ? draw(3) : bad_number()};
    if (k % 17 == 0) {
      const eddie_velocity measured = {chance(80) ? draw(2) : bad_number(),
                                       chance(80) ? draw(4) : bad_number()};
      ours.synchronise({measured.v, measured.omega});
      eddie_velocity_synchronise(&theirs, &measured);
    }
    const auto our = ours.step({torques.left, torques.right});
    const auto their = eddie_velocity_step(&theirs, &torques);
    subject.compare(our.v, their.v);
    subject.compare(our.omega, their.omega);
    subject.compare_wheels(to_rep103(wheel_speeds(robot, our.v, our.omega)),
                           eddie_speeds_of_wheels(&their));
  }
}

void compare_velocities() {
  Subject subject("velocities");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  compare_velocities(subject, {0.7F, 2.5F, 1.5F, 9.0F});
  compare_velocities(subject, {-0.7F, 2.5F, 1.5F, nan});
  compare_velocities(subject, {nan, 0.0F, -1.5F, 9.0F});
}

void compare_samples(Subject& subject, const ReferenceSample<float>& our,
                     const eddie_reference& their) {
  subject.compare(our.x, their.x);
  subject.compare(our.y, their.y);
  subject.compare(our.theta, their.theta);
  subject.compare(our.v, their.v);
  subject.compare(our.tau_left, their.tau_left);
  subject.compare(our.tau_right, their.tau_right);
  subject.compare(our.reverse ? 1 : 0, static_cast<float>(their.reverse));
}

void compare_references() {
  Subject subject("reference");
  for (unsigned long k = 0; k < 3UL * EDDIE_REFERENCE_COUNT; ++k) {
    compare_samples(subject, law::reference.at(k), eddie_reference_at(k));
    compare_samples(subject, law::laps.at(k), eddie_reference_lap(k));
  }
}

}  // namespace

int main() {
  compare_guarded(Bridge::hold, "held");
  compare_guarded(Bridge::repeat, "repeated");
  compare_start();
  compare_wheels();
  compare_velocities();
  compare_references();
  compare_reference_torques();
}
