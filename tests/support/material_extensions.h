// Every property of every material extension, for files that are changed at random.
#pragma once

namespace raygraph::test {

// JSON of a material's `extensions`; there are textures 0 and 1. But for KHR_materials_pbrSpecularGlossiness,
// which excludes others.
inline constexpr const char* kMaterialExtensions = R"({
"KHR_materials_emissive_strength": {"emissiveStrength": 4},
"KHR_materials_ior": {"ior": 1.3},
"KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": 0},
 "specularColorFactor": [1, 2, 3], "specularColorTexture": {"index": 1, "texCoord": 1}},
"KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": {"index": 0}},
"KHR_materials_volume": {"thicknessFactor": 1, "thicknessTexture": {"index": 1},
 "attenuationColor": [0, 0.5, 1], "attenuationDistance": 2},
"KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatTexture": {"index": 0},
 "clearcoatRoughnessFactor": 0.25, "clearcoatRoughnessTexture": {"index": 1},
 "clearcoatNormalTexture": {"index": 0, "scale": 0.5}},
"KHR_materials_sheen": {"sheenColorFactor": [0.5, 1, 0], "sheenColorTexture": {"index": 0},
 "sheenRoughnessFactor": 0.5,
 "sheenRoughnessTexture": {"index": 1, "extensions": {"KHR_texture_transform":
  {"offset": [0, 1], "rotation": 1, "scale": [1, 2], "texCoord": 1}}}},
"KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 3,
 "anisotropyTexture": {"index": 0}},
"KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceTexture": {"index": 0},
 "iridescenceIor": 1.5, "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 500,
 "iridescenceThicknessTexture": {"index": 1}},
"KHR_materials_dispersion": {"dispersion": 0.1},
"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5,
 "diffuseTransmissionTexture": {"index": 0}, "diffuseTransmissionColorFactor": [1, 0.5, 0],
 "diffuseTransmissionColorTexture": {"index": 1}},
"KHR_materials_volume_scatter": {"multiscatterColorFactor": [0.5, 1, 0.25], "scatterAnisotropy": -0.5,
 "multiscatterColorTexture": {"index": 0}},
"KHR_materials_retroreflection": {"retroreflectionFactor": 0.5, "retroreflectionTexture": {"index": 1}}
})";

}  // namespace raygraph::test
