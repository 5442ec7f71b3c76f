#include "graphics_client/viewer/vertex_lighting.h"

#include <vtkShaderProperty.h>

namespace haptics {
namespace {

constexpr const char* kDeclarations = "//VTK::Light::Dec";
constexpr const char* kLighting = "//VTK::Light::Impl";

// VTK 9.1 sets these uniforms, by name, of whatever stage of the program declares them.
constexpr const char* kVertexDeclarations = R"(
uniform vec3 lightColor0;
uniform vec3 lightColor1;
uniform vec3 lightColor2;
uniform vec3 lightDirectionVC0;
uniform vec3 lightDirectionVC1;
uniform vec3 lightDirectionVC2;
uniform float specularPowerUniform;
out vec3 litDiffuse;
out vec3 litSpecular;
void addLight(vec3 color, vec3 along, vec3 normal, vec3 toEye)
{
  float facing = max(0.0, dot(normal, -along));
  litDiffuse += facing * color;
  litSpecular += sign(facing) * pow(max(0.0, dot(reflect(along, normal), toEye)), specularPowerUniform) * color;
}
)";
constexpr const char* kVertexLighting = R"(
  litDiffuse = vec3(0.0);
  litSpecular = vec3(0.0);
  vec3 unitNormal = normalize(normalVCVSOutput);
  vec3 toEye = normalize(-vertexVCVSOutput.xyz);
  addLight(lightColor0, lightDirectionVC0, unitNormal, toEye);
  addLight(lightColor1, lightDirectionVC1, unitNormal, toEye);
  addLight(lightColor2, lightDirectionVC2, unitNormal, toEye);
)";
constexpr const char* kPixelDeclarations = R"(
//VTK::Light::Dec
in vec3 litDiffuse;
in vec3 litSpecular;
)";
constexpr const char* kPixelLighting = R"(
  fragOutput0 = vec4(ambientColor + litDiffuse * diffuseColor + litSpecular * specularColor, 1.0);
)";

}  // namespace

void lightVertices(vtkActor* actor, bool on) {
  vtkShaderProperty* shaders = actor->GetShaderProperty();
  if ((shaders->GetNumberOfShaderReplacements() > 0) == on) return;
  shaders->ClearAllShaderReplacements();
  if (!on) return;
  shaders->AddVertexShaderReplacement(kDeclarations, true, kVertexDeclarations, false);
  shaders->AddVertexShaderReplacement(kLighting, true, kVertexLighting, false);
  shaders->AddFragmentShaderReplacement(kDeclarations, true, kPixelDeclarations, false);
  shaders->AddFragmentShaderReplacement(kLighting, true, kPixelLighting, false);
}

}  // namespace haptics
