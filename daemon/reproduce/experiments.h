// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/reproduce/experiment.h"

// The experiments, one function each, by the topic of the thesis. All throw Cancelled.
namespace geond::reproduce {

// The bowling pin as two geons, Table 1.1.
Experiment PinTable(const Run& run);
// Charge on wedges of many angles (4.1), Fig. 4.3.
Experiment EdgeLaw(const Run& run);
// Charge round an ellipse against (6.2), Fig. 6.4.
Experiment Ellipse(const Run& run);
// Charge round a hypocycloid and an epicycloid, Fig. 6.5.
Experiment Cycloids(const Run& run);

// Corners of noisy contours by charge and by curvature, Figs. 6.6 and 6.7.
Experiment ContourNoise(const Run& run);
// Fine and gross structure of a wiggly dumbbell, Fig. 6.8.
Experiment WigglyDumbbell(const Run& run);
// Charge at the tips of arms of different length, Fig. 6.9.
Experiment PartSignificance(const Run& run);
// The invented side of a single view and the minima of charge, Fig. C.3.
Experiment InvisibleSide(const Run& run);
// Charge and parts of vase, pin, elephant, owl and clock, Figs. 6.10 to 6.16.
Experiment SolidObjects(const Run& run);
// Seven models on seven objects, Table 6.1 and Fig. 6.17.
Experiment GeonTable(const Run& run);
// Eleven bananas from four views, Table 6.2, Figs. 6.18 to 6.21.
Experiment BananaTable(const Run& run);
// Bananas and a tube from single views, Figs. 6.22 to 6.24.
Experiment BananaViews(const Run& run);
// Whole objects as geons, Fig. 6.25.
Experiment MultiPartObjects(const Run& run);
// The two terms of the objective during annealing, Fig. 5.11.
Experiment AnnealingTrace(const Run& run);
// Times of charge and fits, sections 6.3 and 6.5.
Experiment Timing(const Run& run);
// Beside other programs, on the same inputs.
Experiment Peers(const Run& run);

}  // namespace geond::reproduce
