// egosieve render DIR: render/NNNNNN.png and overlay.mp4.
#ifndef EGOSIEVE_TOOLS_RENDER_RENDER_COMMAND_H_
#define EGOSIEVE_TOOLS_RENDER_RENDER_COMMAND_H_

#include <memory>

#include "tools/cli/command.h"

namespace egosieve::tools {

std::unique_ptr<Command> MakeRenderCommand();

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_RENDER_RENDER_COMMAND_H_
