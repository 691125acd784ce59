// One of the shells as the top of a design for ICSC; the macro selects it. Unbound ports become those of the design.
#include <systemc>

#if defined(SELFPROJ_SHELL_column_moments)
#include "hls/shells/column_moments_shell.h"
using Shell = selfproj::hls::ColumnMomentsShell;
#elif defined(SELFPROJ_SHELL_gray_decoder)
#include "hls/shells/gray_decoder_shell.h"
using Shell = selfproj::hls::GrayDecoderShell;
#else
#include "hls/shells/median3x3_shell.h"
using Shell = selfproj::hls::Median3x3Shell;
#endif

int sc_main(int /*argc*/, char** /*argv*/) {
  Shell shell("shell");
  sc_core::sc_start();
  return 0;
}
