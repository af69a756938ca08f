// egosieve report DIR: report.html.
#ifndef EGOSIEVE_TOOLS_REPORT_REPORT_COMMAND_H_
#define EGOSIEVE_TOOLS_REPORT_REPORT_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeReportCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_REPORT_REPORT_COMMAND_H_
