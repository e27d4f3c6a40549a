// What the tests of Guarded and Bumpless share: two equal laws, one of them to compare with.
#pragma once

#include "nfopidn/firmware/bumpless.hpp"
#include "nfopidn/firmware/guarded.hpp"
#include "support.hpp"

namespace nfopidn::test {

template <class Scalar>
struct Rig {
  using Law = Controller<Scalar, Fir<Scalar, 7>>;
  Law law;
  Law plain;
  Draws draw{7};

  explicit Rig(Form form = Form::positional) {
    ControllerSettings<Scalar> settings;
    settings.form = form;
    EXPECT_EQ(law.configure(settings), Status::ok);
    EXPECT_EQ(plain.configure(settings), Status::ok);
  }
  Measurement<Scalar> measured() { return random_measurement<Scalar>(draw); }
  ReferenceSample<Scalar> reference() { return random_reference<Scalar>(draw); }
};

template <class Scalar>
TorquePair<Scalar> no_torque() {
  return {0, 0};
}

constexpr Form both_forms[] = {Form::positional, Form::incremental};

}  // namespace nfopidn::test
