// The files of an inspection: tables, cloud, images and report. docs/outputs.md has their formats and signs.
#ifndef SELFPROJ_HOST_REPORT_INSPECTION_OUTPUT_H
#define SELFPROJ_HOST_REPORT_INSPECTION_OUTPUT_H

#include "host/files/output_folder.h"
#include "host/report/report.h"
#include "selfproj/light_section/inspection.h"

namespace selfproj::report {

// Writes all files into the folder, without committing it. Throws UserError if there is no frame to write, and as
// OutputFolder does.
void write_inspection(const light_section::Inspection& inspection, files::OutputFolder& folder,
                      const ReportParts& parts = {});

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_INSPECTION_OUTPUT_H
