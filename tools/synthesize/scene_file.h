// scene.json: the description of a synthetic drive (synthesize.h explains the fields).
#ifndef EGOSIEVE_TOOLS_SYNTHESIZE_SCENE_FILE_H_
#define EGOSIEVE_TOOLS_SYNTHESIZE_SCENE_FILE_H_

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "vision/synthetic/street.h"

namespace egosieve::tools {

// All except the frames, which are to be appended to the array "frames".
nlohmann::ordered_json DescribeScenario(const vision::Scenario& scenario, bool video);
nlohmann::ordered_json DescribeFrame(const vision::SyntheticFrame& frame);

// camera.json: the lens, and the rate of the frames.
std::string CameraText(const vision::Scenario& scenario);
// A line of poses.txt: the 12 numbers of [R centre], row by row.
std::string PoseLine(const vision::Pose& pose);

// The document's text: one line per frame.
std::string SceneText(const nlohmann::ordered_json& scene);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SYNTHESIZE_SCENE_FILE_H_
