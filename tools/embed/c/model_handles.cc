#include "tools/embed/c/model_handles.h"

namespace egosieve::embed {

Models& AllModels() {
  static Models* models = new Models;
  return *models;
}

Posteriors& AllPosteriors() {
  static Posteriors* posteriors = new Posteriors;
  return *posteriors;
}

}  // namespace egosieve::embed
