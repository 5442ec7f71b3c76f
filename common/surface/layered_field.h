#pragma once

#include <memory>
#include <vector>

#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// Fields together (paper 4.3.3 (b): texturing functions in combination "to generate more-sophisticated surface details"):
///   sum      f = sum of w_i f_i,      grad f = sum of w_i grad f_i
///   product  f = product of w_i f_i,  grad f = sum over i of w_i grad f_i * (product of the other w_j f_j)
/// Bounds: by interval arithmetic, as near as the layers' own where these do not depend on each other. The finest detail
/// of a sum is that of its finest layer; of a product 1 / sum of 1 / wavelength_i, for cos a cos b is of a + b and a - b.
class LayeredField final : public ScalarField {
 public:
  struct Layer {
    double weight;
    std::shared_ptr<const ScalarField> field;
  };

  /// \param layers one or more.
  LayeredField(LayeredFamily::Combination combination, std::vector<Layer> layers);
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override;

 private:
  LayeredFamily::Combination combination_;
  std::vector<Layer> layers_;
};

}  // namespace haptics
