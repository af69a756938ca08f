#include "vision/synthetic/scenario_catalogue.h"

#include "vision/synthetic/street_grid.h"

namespace egosieve::vision {
namespace {

constexpr ObjectClass kCar = ObjectClass::kCar;
constexpr ObjectClass kVan = ObjectClass::kVan;
constexpr ObjectClass kBus = ObjectClass::kBus;

void Street(SceneBuilder& s) {
  s.DriveCamera(-36.0, {{0.0, 5.5}, {5.0, 5.0}, {8.0, 7.0}});
  s.scene.camera.bumps_metres = {24.0};
  s.CrossingStream(1.3, 8.0);
  s.CrossingWalkers(7.0);
  s.Ahead(kCar, -16.0, {{0.0, 6.0}, {5.0, 8.0}});
  s.OncomingStream(45.0, 8.0);
  s.Cyclist(-14.0, 3.6, false);
  s.Walkers(4.0);
}

void Junction(SceneBuilder& s) {
  s.DriveCamera(-18.0, {{0.0, 1.6}, {5.0, 1.2}});
  s.CrossingStream(1.5, 5.0);
  for (int k = 0; k < 8; ++k) {
    s.CrossingWalker(-7.5 + 0.3 * k, k % 2 == 0 ? 1 : -1, -5.0 + 1.6 * k, s.Uniform(1.2, 1.8));
  }
  s.OncomingStream(40.0, 7.0);
  s.Walkers(5.0);
}

// Twelve metres of bus, five to ten metres away.
void Buses(SceneBuilder& s) {
  s.DriveCamera(-15.0, {{0.0, 1.0}});
  for (double t = -6.0; t < s.duration() + 6.0; t += s.Uniform(3.6, 4.4)) {
    s.Crossing(kBus, 0, -1, t, 4.0);
  }
  for (double t = -5.0; t < s.duration() + 5.0; t += s.Uniform(3.2, 5.0)) {
    s.Crossing(s.Uniform(0.0, 1.0) < 0.6 ? kBus : kVan, 0, 1, t, 5.0);
  }
  s.Walkers(5.0);
}

void Crossing(SceneBuilder& s) {
  s.DriveCamera(-40.0, {{0.0, 4.5}});
  s.Crossing(kBus, 0, 1, 3.0, 7.0);
  s.CrossingStream(1.2, 8.0);
  for (double x = 14.0; x < 40.0; x += 8.0) s.Oncoming(kCar, x, {});  // wait at the stop line
  s.Walkers(3.0);
}

void Oncoming(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 9.0}});
  s.Oncoming(kBus, 40.0, {{0.0, 8.0}});
  s.OncomingStream(22.0, 10.0);
}

void Ahead(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 9.0}});
  // Falls back, keeps its distance, then pulls away.
  s.Ahead(kCar, -46.0, {{0.0, 9.0}, {2.0, 9.0}, {4.0, 7.6}, {5.0, 9.0}, {7.0, 9.0}, {9.0, 11.5}});
  s.Ahead(kVan, -26.0, {{0.0, 9.0}, {3.0, 10.0}});
}

void Overtaking(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 7.0}});
  s.Overtaker(kCar, -74.0, 13.0, 46.0);
  s.Overtaker(kVan, -98.0, 12.0, 0.0);
  s.Overtaker(kCar, -122.0, 13.0, 95.0);
  s.Cyclist(-44.0, 3.8, false);
  s.Cyclist(-22.0, 4.4, false);
}

void StandingTraffic(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 6.5}});
  for (double x = -46.0; x < 110.0; x += 7.2) s.Oncoming(x > 0 && x < 8.0 ? kVan : kCar, x, {});
  s.Ahead(kCar, 12.0, {{6.0, 0.0}, {9.0, 7.5}});
  s.Ahead(kBus, 24.0, {{5.0, 0.0}, {8.0, 8.0}});
  s.Walkers(5.0);
}

void StopAndGo(SceneBuilder& s) {
  s.DriveCamera(-52.0, {{0.0, 8.0}, {1.0, 8.0}, {4.2, 0.0}, {6.6, 0.0}, {9.5, 7.0}});
  s.Ahead(kCar, -41.0, {{0.0, 8.0}, {0.7, 8.0}, {3.9, 0.0}, {6.0, 0.0}, {8.6, 8.0}});
  s.CrossingStream(1.6, 8.5);
  s.CrossingWalker(-8.0, 1, 4.6, 1.5);
  s.CrossingWalker(-7.4, -1, 4.9, 1.4);
  s.OncomingStream(45.0, 8.0);
  s.Walkers(6.0);
}

void Pedestrians(SceneBuilder& s) {
  s.DriveCamera(-58.0, {{0.0, 5.0}});
  s.CrossingWalkers(4.0);
  s.CrossingWalker(-8.2, 1, 1.5, 1.4);
  s.CrossingWalker(-7.2, -1, 2.2, 1.3);
  s.Walkers(20.0);
}

void Turning(SceneBuilder& s) {
  s.TurnCamera(-42.0, 1, {{0.0, 8.0}, {2.5, 8.0}, {4.5, 4.5}, {7.5, 4.5}, {9.5, 8.0}});
  s.CrossingStream(2.6, 8.0);
  s.OncomingStream(40.0, 8.0);
  s.Crossing(kCar, 0, -1, 8.0, 7.0);
  s.Walkers(8.0);
}

void Bus(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 7.0}});
  s.Ahead(kBus, -42.0, {{0.0, 7.5}, {3.0, 6.5}, {6.0, 8.0}});
  s.Oncoming(kBus, 30.0, {{0.0, 7.0}});
  s.Cyclist(-20.0, 5.0, true);
  s.Cyclist(-10.0, 4.5, true);
  s.Crossing(kBus, 1, -1, 6.0, 8.0);
  s.Walkers(6.0);
}

void Handheld(SceneBuilder& s) {
  s.WalkCamera(-40.0, 1.3, 0.10, 0.35);
  s.CrossingStream(2.5, 8.0);
  s.OncomingStream(26.0, 8.5);
  s.Ahead(kCar, -62.0, {{0.0, 9.0}});
  s.Ahead(kVan, -92.0, {{0.0, 9.0}});
  s.Ahead(kCar, -120.0, {{0.0, 9.0}});
  s.Cyclist(-52.0, 4.5, false);
  s.Walkers(12.0);
}

// Buses that crawl past at six metres. Only the houses above and between them are static.
void BusStop(SceneBuilder& s) {
  s.WalkCamera(-30.0, 1.4, 0.05, 1.05);
  for (int k = 0; k < 6; ++k) {
    s.Ahead(k % 3 == 1 ? kVan : kBus, -80.0 + 14.5 * k,
            {{0.0, 6.0}, {2.5, 3.0}, {4.0, 3.0}, {6.0, 7.0}, {8.0, 2.5}, {10.0, 5.0}});
  }
  s.OncomingStream(26.0, 8.0);
}

void Panning(SceneBuilder& s) {
  s.WalkCamera(-24.0, 0.0, 0.03, 1.1);
  s.scene.camera.pan_radians_per_second = -0.10;
  s.OncomingStream(22.0, 8.0);
  for (int k = 0; k < 5; ++k) s.Ahead(k == 2 ? kBus : kCar, -50.0 - 24.0 * k, {{0.0, 8.5}});
  s.Walkers(10.0);
}

void Walk(SceneBuilder& s) {
  s.WalkCamera(-40.0, 1.35, 0.05, 0.10);
  s.scene.camera.shake_radians = 0.006;
  s.scene.camera.shake_metres = 0.012;
  s.LineTheWay();
  for (int k = 0; k < 6; ++k) {
    s.Walker(-34.0 + 5.0 * k, -1, k % 3 == 2 ? -1 : 1, s.Uniform(1.1, 1.9), s.Uniform(7.3, 8.4));
  }
  s.OncomingStream(30.0, 8.0);
  s.Ahead(kCar, -58.0, {{0.0, 8.0}});
  s.Ahead(kVan, -84.0, {{0.0, 8.5}});
  s.Cyclist(-50.0, 4.2, false);
}

void Cyclists(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 5.5}, {4.0, 4.6}});
  for (int k = 0; k < 10; ++k) {
    s.Cyclist(-52.0 + 11.0 * k + s.Uniform(0.0, 4.0), s.Uniform(3.6, 5.2), false);
  }
  s.Ahead(ObjectClass::kCyclist, -44.0, {{0.0, 4.7}, {6.0, 4.4}});
  s.Ahead(ObjectClass::kCyclist, -24.0, {{0.0, 4.5}});
  s.Ahead(ObjectClass::kPedestrian, -14.0, {{0.0, 2.6}});
  const double end = s.CameraX(s.duration()) + 40.0;
  for (double x = -56.0; x < end; x += s.Uniform(5.0, 9.0)) {
    s.Walker(x, s.Uniform(0.0, 1.0) < 0.7 ? -1 : 1, 1, s.Uniform(1.0, 2.6), s.Uniform(6.2, 8.4));
  }
}

void Dashcam(SceneBuilder& s) {
  Street(s);
  s.scene.own_vehicle.visible = true;
}

void Clouds(SceneBuilder& s) {
  Street(s);
  s.scene.light.cloud_cover = 0.9;
  s.scene.light.wind = {14.0, 9.0};
  s.town.max_height_metres = 36.0;
  s.town.min_height_metres = 12.0;
}

void Textureless(SceneBuilder& s) {
  Street(s);
  s.scene.ground.texture = 0.0f;
  s.scene.ground.markings = false;
  s.scene.texture = 0.25f;
}

void Night(SceneBuilder& s) {
  s.scene.light.night = true;
  s.scene.light.sky = Color(0.016f, 0.019f, 0.03f);
  s.scene.light.bounce = Color(0.012f, 0.011f, 0.01f);
  s.scene.sensor.exposure = 3.2;
  s.scene.sensor.read_noise = 0.012;
  s.scene.sensor.shot_noise = 0.025;
  s.scene.sensor.shutter_seconds = 0.012;
  Street(s);
}

void Rounds(SceneBuilder& s) {
  s.RoundCamera(45.0);
  s.TrafficRound(4.0, 6.0);
}

void Empty(SceneBuilder& s) {
  s.DriveCamera(-62.0, {{0.0, 9.0}});
  s.scene.camera.bumps_metres = {30.0};
  for (double x = 14.0; x < 40.0; x += 9.0) s.Oncoming(kCar, x, {});
}

}  // namespace

const std::vector<SceneRecipe>& Recipes() {
  static const auto* const recipes = new std::vector<SceneRecipe>{
      {"street", "a town drive: cars ahead, oncoming and crossing, a cyclist, people", Street},
      {"junction", "slowly up to a junction that cars and people cross", Junction},
      {"crossing", "towards a junction that cars and a bus cross", Crossing},
      {"buses", "slowly up to a junction where buses fill the picture", Buses},
      {"oncoming", "a stream of oncoming cars and a bus", Oncoming},
      {"ahead", "a car ahead in the lane: same speed, slower, faster", Ahead},
      {"overtaking", "cars overtake the camera, the camera overtakes cyclists", Overtaking},
      {"standing_traffic", "past a standing queue; two vehicles ahead start to move",
       StandingTraffic},
      {"stop_and_go", "the camera stops behind a car while others cross, and goes on", StopAndGo},
      {"pedestrians", "people on the pavements and across the road", Pedestrians},
      {"turning", "the camera turns left at a junction", Turning},
      {"bus", "buses ahead, oncoming and crossing; cyclists", Bus},
      {"handheld", "a camera in the hand of someone who walks", Handheld},
      {"bus_stop", "a camera in a hand, turned to the road: buses crawl past and fill the picture",
       BusStop},
      {"panning", "a camera that turns on the spot: no parallax", Panning},
      {"walk", "a shaking camera in a hand, close past trunks and railings", Walk},
      {"cyclists", "cyclists and people ahead, in the camera's own direction", Cyclists},
      {"dashcam", "street, with bonnet, bracket, time stamp and reflections in the windscreen",
       Dashcam},
      {"clouds", "fast clouds and tall houses change the light", Clouds},
      {"textureless", "a road without texture or markings, plain walls", Textureless},
      {"night", "street lamps and headlights, a noisy sensor", Night},
      {"rounds", "round one block, every 45 s by the same places among other traffic", Rounds},
      {"empty", "a drive on which nothing else moves", Empty},
  };
  return *recipes;
}

const SceneRecipe* FindRecipe(std::string_view name) {
  for (const SceneRecipe& recipe : Recipes()) {
    if (recipe.name == name) return &recipe;
  }
  return nullptr;
}

Scene BuildScene(const SceneRecipe& recipe, uint64_t seed, double duration_seconds) {
  SceneBuilder builder(seed, duration_seconds);
  recipe.build(builder);
  return builder.Finish();
}

}  // namespace egosieve::vision
