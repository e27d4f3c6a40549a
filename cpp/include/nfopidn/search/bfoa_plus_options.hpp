// L3. Settings of cognitive bacterial foraging.
#pragma once

#include "nfopidn/foundation/schema.hpp"

namespace nfopidn {

struct BfoaPlusOptions {
  int cells = 64;
  int evaluations_per_cell = 150;
  int blind_cells = 20;
  int colonies = 4;
  int first_points = 300;
  double differential_share = 0.65;
  double blind_differential_share = 0.9;
  double step = 0.1;
  double foraging_share = 0.4;
  double blind_foraging_share = 0.7;
  int finishers = 3;
  int restart_points = 40;
  int scan_points = 90;
  double patience = 15;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using B = BfoaPlusOptions;
    visit(field("cells", &B::cells, "", between(4, 10000), "most cells, with exact gradients"));
    visit(field("evaluations_per_cell", &B::evaluations_per_cell, "", between(1, 1e9),
                "there are fewer cells where the budget has less than this for each, down to 4; "
                "with exact gradients"));
    visit(field("blind_cells", &B::blind_cells, "", between(4, 10000),
                "cells, without gradients: fewer live longer"));
    visit(field("colonies", &B::colonies, "", between(1, 1000),
                "groups of cells, each of at least 4, that do not see each other; with exact "
                "gradients"));
    visit(field("first_points", &B::first_points, "", between(4, 1e6),
                "points of the Latin hypercube; the best become cells"));
    visit(field("differential_share", &B::differential_share, "", between(0, 1),
                "share of tumbles along differences between cells, with exact gradients"));
    visit(field("blind_differential_share", &B::blind_differential_share, "", between(0, 1),
                "the same without gradients"));
    visit(field("step", &B::step, "", between(1e-9, 1),
                "first step of the sparse tumbles, in units of the box"));
    visit(field("foraging_share", &B::foraging_share, "", between(0, 1),
                "share of the evaluations before the descent, with exact gradients"));
    visit(field("blind_foraging_share", &B::blind_foraging_share, "", between(0, 1),
                "the same without gradients"));
    visit(field("finishers", &B::finishers, "", between(1, 1000),
                "cells, apart from each other, from which a descent starts; one without "
                "gradients"));
    visit(
        field("restart_points", &B::restart_points, "", between(0, 1e6),
              "points anywhere, the best of which starts a further descent; 0: jumps off the best "
              "point; with exact gradients"));
    visit(field("scan_points", &B::scan_points, "", between(0, 1e6),
                "points along each coordinate, over the whole box, among which other pits are "
                "looked for after the descent; without gradients"));
    visit(field("patience", &B::patience, "", between(0, 1e9),
                "a descent is given up that, at the pace of its last eight steps, is more than so "
                "many times eight steps from the best; with exact gradients"));
  }
};

}  // namespace nfopidn
