// The runner of co-simulations: frames through the platform, packets through the driver, every packet compared with the
// model's. What is measured of them is a CosimMeasurement (cosim_measurement.h).
#ifndef SELFPROJ_SIM_EXPERIMENT_COSIM_H
#define SELFPROJ_SIM_EXPERIMENT_COSIM_H

#include "sim/experiment/cosim_options.h"

namespace selfproj {

// `selfproj-sim cosim`: runs, writes what was asked for, and prints what was found. The last line says what was
// compared: "matched 716800 columns in 1400 frames, 0 mismatches". Throws UserError naming what is wrong, CheckFailed
// where something differs from the model.
void run_cosim(const CosimOptions& options);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_COSIM_H
