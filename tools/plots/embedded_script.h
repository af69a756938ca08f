// The text of plot.py.
#ifndef EGOSIEVE_TOOLS_PLOTS_EMBEDDED_SCRIPT_H_
#define EGOSIEVE_TOOLS_PLOTS_EMBEDDED_SCRIPT_H_

namespace egosieve::tools {

extern const char kPlotScript[];

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_PLOTS_EMBEDDED_SCRIPT_H_
