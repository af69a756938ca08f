// Compiled when a program is linked: --embed_label and --stamp name the commit.
namespace egosieve::tools {

extern const char kBuildLabel[];
const char kBuildLabel[] = BUILD_EMBED_LABEL;

}  // namespace egosieve::tools
