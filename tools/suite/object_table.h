// Movers found, by group (heading, class, size, distance), pooled over a suite's sequences, one
// column per variant: in the maps, and by the numbers of reconstruct where it has run.
//
//   recall   share of the group's objects, frame by frame, found with an IoU of at least 0.3, and
//            of at least 0.5
//   false    objects per frame that lie on nothing that moves
#ifndef EGOSIEVE_TOOLS_SUITE_OBJECT_TABLE_H_
#define EGOSIEVE_TOOLS_SUITE_OBJECT_TABLE_H_

#include <string>
#include <vector>

#include "tools/suite/suite_run.h"

namespace egosieve::tools {

// Empty if no sequence numbers its objects.
std::string ObjectTable(const std::vector<SequenceResult>& results);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_OBJECT_TABLE_H_
