// SPDX-License-Identifier: Apache-2.0
// The line from simulated views to the description, as `geon describe` goes it.
#include <gtest/gtest.h>

#include "calib/make_view.h"
#include "calib/register_views.h"
#include "core/object_model.h"
#include "sim/simulate_scan.h"

namespace geond {
namespace {

sim::Scene SceneOf(const std::string& name) {
  return sim::ReadScene(std::filesystem::path(GEOND_SOURCE_DIR) / "config/scenes" / (name + ".toml"));
}

ObjectModel Described(const sim::Scene& scene, int views) {
  sim::SimOptions options;
  options.views = views;
  options.columns = options.rows = 160;
  std::vector<RangeView> range_views = calib::MakeViews(sim::SimulateScan(scene, options));
  const calib::RegistrationResult registered = calib::RegisterViews(range_views);
  for (std::size_t i = 0; i < range_views.size(); ++i) range_views[i].X_TS = registered.X_TS[i];
  return BuildObjectModel(range_views);
}

// Each true part is the described part that lies nearest, of the same type. Returns the worst error of its three half
// sizes, relative.
double WorstSizeError(const sim::Scene& scene, const ObjectDescription& description) {
  double worst = 0.0;
  for (const sim::Scene::Part& part : scene.parts) {
    const Geon truth = Canonical(part.geon);
    const DescribedPart* nearest = nullptr;
    const auto distance = [&](const DescribedPart& found) {
      return (found.geon().X_TG.translation() - truth.X_TG.translation()).norm();
    };
    for (const DescribedPart& found : description.parts) {
      if (!nearest || distance(found) < distance(*nearest)) nearest = &found;
    }
    EXPECT_EQ(nearest->geon().type, truth.type) << part.name;
    for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(nearest->geon().size[k] / truth.size[k] - 1.0));
  }
  return worst;
}

TEST(Line, FourViewsOfThePinAreItsTwoGeons) {
  const sim::Scene pin = SceneOf("bowling_pin");
  const ObjectModel model = Described(pin, 4);
  ASSERT_EQ(model.description.parts.size(), pin.parts.size());
  EXPECT_LT(WorstSizeError(pin, model.description), 0.04);
}

TEST(Line, OneViewOfTheOwlIsItsThreeGeons) {
  const sim::Scene owl = SceneOf("owl");
  const ObjectModel model = Described(owl, 1);
  ASSERT_EQ(model.description.parts.size(), owl.parts.size());
  WorstSizeError(owl, model.description);
}

TEST(Line, OneViewOfACylinderIsNotCut) {
  const sim::Scene cylinder = SceneOf("cylinder");
  const ObjectModel model = Described(cylinder, 1);
  ASSERT_EQ(model.description.parts.size(), 1u);
  EXPECT_LT(WorstSizeError(cylinder, model.description), 0.08);
}

}  // namespace
}  // namespace geond
