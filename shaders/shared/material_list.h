// The fields of a material, one row each, in the order of scene::Material, which declares them with their
// defaults. Everything else that handles each field is generated from these rows: the record and its copy,
// the surface that lobes read, the schema and importer of glTF, checks, saver, hash, inspector and tests. A
// scene's hash takes the fields in this order, so existing rows stay in order; a new row goes before the last
// two, isSpecularGlossiness and priority.
//
// To include this, define some of these; others expand to nothing, FACTOR to its VALUE and TEXTURE, and
// NUMBER to its VALUE:
//   RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity)
//       nameFactor and nameTexture of the material, keyFactor and keyTexture in the file. The record has
//       both; SurfaceMaterial has the factor times these channels of the texture, set as for NUMBER
//   RAYGRAPH_MATERIAL_NUMBER(type, name, field, object, key, feature, quantity)
//       a field of the material that is `name` in the record and in SurfaceMaterial, where it is set only if
//       the scene has the trace feature (kTrace##feature of trace_feature_list.h)
//   RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity)
//       one that is `name` in the record alone
//   RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space)
//       nameTexture of the material, in the record with its transform
//   RAYGRAPH_MATERIAL_FIELD(field, object, key, quantity)
//       one that is not in the record, or that ToRecord (scene_materials.cpp) makes something of
//   RAYGRAPH_MATERIAL_FLAG(field, object)    whether the object is there
//   RAYGRAPH_MATERIAL_UNSHOWN(name, object, key, space)  a texture that pictures do not depend on
// object, key: where glTF has it: in the `material` itself, an object in it, an extension, or its `extras`. A
//   key may go down a level.
// space: of a texture's red, green and blue
// quantity: its range and unit (renderer/scene/model/scene_fields.h)
#ifndef RAYGRAPH_MATERIAL_VALUE
#define RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity)
#endif
#ifndef RAYGRAPH_MATERIAL_TEXTURE
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space)
#endif
#ifndef RAYGRAPH_MATERIAL_FACTOR
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity) \
    RAYGRAPH_MATERIAL_VALUE(type, name, name##Factor, object, key##Factor, quantity)          \
    RAYGRAPH_MATERIAL_TEXTURE(name, object, key##Texture, space)
#endif
#ifndef RAYGRAPH_MATERIAL_NUMBER
#define RAYGRAPH_MATERIAL_NUMBER(type, name, field, object, key, feature, quantity) \
    RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity)
#endif
#ifndef RAYGRAPH_MATERIAL_FIELD
#define RAYGRAPH_MATERIAL_FIELD(field, object, key, quantity)
#endif
#ifndef RAYGRAPH_MATERIAL_FLAG
#define RAYGRAPH_MATERIAL_FLAG(field, object)
#endif
#ifndef RAYGRAPH_MATERIAL_UNSHOWN
#define RAYGRAPH_MATERIAL_UNSHOWN(name, object, key, space)
#endif

RAYGRAPH_MATERIAL_VALUE(vec4, baseColor, baseColorFactor, pbrMetallicRoughness, baseColorFactor, kShare)
RAYGRAPH_MATERIAL_TEXTURE(baseColor, pbrMetallicRoughness, baseColorTexture, Srgb)
RAYGRAPH_MATERIAL_VALUE(float, metallic, metallicFactor, pbrMetallicRoughness, metallicFactor, kShare)
RAYGRAPH_MATERIAL_VALUE(float, roughness, roughnessFactor, pbrMetallicRoughness, roughnessFactor, kShare)
// roughness in green, metallic in blue
RAYGRAPH_MATERIAL_TEXTURE(metallicRoughness, pbrMetallicRoughness, metallicRoughnessTexture, Linear)
RAYGRAPH_MATERIAL_TEXTURE(normal, material, normalTexture, Linear)
RAYGRAPH_MATERIAL_VALUE(float, normalScale, normalScale, normalTexture, scale, kAnyNumber)
RAYGRAPH_MATERIAL_UNSHOWN(occlusion, material, occlusionTexture, Linear)
RAYGRAPH_MATERIAL_FIELD(occlusionStrength, occlusionTexture, strength, kShare)
RAYGRAPH_MATERIAL_FIELD(emissiveFactor, material, emissiveFactor, kColorBesideStrength)
RAYGRAPH_MATERIAL_FIELD(emissiveStrength, KHR_materials_emissive_strength, emissiveStrength, kRadiance)
RAYGRAPH_MATERIAL_TEXTURE(emissive, material, emissiveTexture, Srgb)
RAYGRAPH_MATERIAL_FIELD(alphaMode, material, alphaMode, kNoNumber)
RAYGRAPH_MATERIAL_VALUE(float, alphaCutoff, alphaCutoff, material, alphaCutoff, kNotNegative)
RAYGRAPH_MATERIAL_FIELD(isDoubleSided, material, doubleSided, kNoNumber)

RAYGRAPH_MATERIAL_FIELD(ior, KHR_materials_ior, ior, kIndex)
RAYGRAPH_MATERIAL_VALUE(float, specular, specularFactor, KHR_materials_specular, specularFactor, kShare)
RAYGRAPH_MATERIAL_TEXTURE(specular, KHR_materials_specular, specularTexture, Linear)  // alpha
RAYGRAPH_MATERIAL_VALUE(vec3, specularColor, specularColorFactor, KHR_materials_specular, specularColorFactor,
                        kNotNegative)
RAYGRAPH_MATERIAL_TEXTURE(specularColor, KHR_materials_specular, specularColorTexture, Srgb)
RAYGRAPH_MATERIAL_VALUE(float, transmission, transmissionFactor, KHR_materials_transmission,
                        transmissionFactor, kShare)
RAYGRAPH_MATERIAL_TEXTURE(transmission, KHR_materials_transmission, transmissionTexture, Linear)  // red
RAYGRAPH_MATERIAL_VALUE(float, thickness, thicknessFactor, KHR_materials_volume, thicknessFactor, kLength)
RAYGRAPH_MATERIAL_FIELD(attenuationColor, KHR_materials_volume, attenuationColor, kShare)
RAYGRAPH_MATERIAL_FIELD(attenuationDistance, KHR_materials_volume, attenuationDistance, kDistance)
RAYGRAPH_MATERIAL_FLAG(isUnlit, KHR_materials_unlit)
RAYGRAPH_MATERIAL_FACTOR(float, clearcoat, KHR_materials_clearcoat, clearcoat, x, Linear, Clearcoat, kShare)
RAYGRAPH_MATERIAL_FACTOR(float, clearcoatRoughness, KHR_materials_clearcoat, clearcoatRoughness, y, Linear,
                         Clearcoat, kShare)
RAYGRAPH_MATERIAL_TEXTURE(clearcoatNormal, KHR_materials_clearcoat, clearcoatNormalTexture, Linear)
RAYGRAPH_MATERIAL_VALUE(float, clearcoatNormalScale, clearcoatNormalScale, KHR_materials_clearcoat,
                        clearcoatNormalTexture.scale, kAnyNumber)
RAYGRAPH_MATERIAL_FACTOR(vec3, sheenColor, KHR_materials_sheen, sheenColor, xyz, Srgb, Sheen, kShare)
RAYGRAPH_MATERIAL_FACTOR(float, sheenRoughness, KHR_materials_sheen, sheenRoughness, w, Linear, Sheen, kShare)
RAYGRAPH_MATERIAL_VALUE(float, anisotropy, anisotropyStrength, KHR_materials_anisotropy, anisotropyStrength,
                        kShare)
RAYGRAPH_MATERIAL_VALUE(float, anisotropyRotation, anisotropyRotation, KHR_materials_anisotropy,
                        anisotropyRotation, kAngle)
RAYGRAPH_MATERIAL_TEXTURE(anisotropy, KHR_materials_anisotropy, anisotropyTexture, Linear)
RAYGRAPH_MATERIAL_FACTOR(float, iridescence, KHR_materials_iridescence, iridescence, x, Linear, Iridescence,
                         kShare)
RAYGRAPH_MATERIAL_NUMBER(float, iridescenceIor, iridescenceIor, KHR_materials_iridescence, iridescenceIor,
                         Iridescence, kFilmIndex)
RAYGRAPH_MATERIAL_FIELD(iridescenceThicknessMinimum, KHR_materials_iridescence, iridescenceThicknessMinimum,
                        kFilmThickness)
RAYGRAPH_MATERIAL_FIELD(iridescenceThicknessMaximum, KHR_materials_iridescence, iridescenceThicknessMaximum,
                        kFilmThickness)
RAYGRAPH_MATERIAL_TEXTURE(iridescenceThickness, KHR_materials_iridescence, iridescenceThicknessTexture,
                          Linear)
RAYGRAPH_MATERIAL_VALUE(float, dispersion, dispersion, KHR_materials_dispersion, dispersion, kNotNegative)
RAYGRAPH_MATERIAL_FACTOR(float, diffuseTransmission, KHR_materials_diffuse_transmission, diffuseTransmission,
                         w, Linear, DiffuseTransmission, kShare)
RAYGRAPH_MATERIAL_FACTOR(vec3, diffuseTransmissionColor, KHR_materials_diffuse_transmission,
                         diffuseTransmissionColor, xyz, Srgb, DiffuseTransmission, kShare)
RAYGRAPH_MATERIAL_FACTOR(float, retroreflection, KHR_materials_retroreflection, retroreflection, x, Linear,
                         Retroreflection, kShare)
RAYGRAPH_MATERIAL_FIELD(multiscatterColorFactor, KHR_materials_volume_scatter, multiscatterColorFactor,
                        kShare)
RAYGRAPH_MATERIAL_FIELD(scatterAnisotropy, KHR_materials_volume_scatter, scatterAnisotropy, kMeanCosine)
RAYGRAPH_MATERIAL_FACTOR(float, scatterStrength, KHR_materials_scatter, scatterStrength, w, Linear,
                         ThinScatter, kShare)
RAYGRAPH_MATERIAL_FACTOR(vec3, scatterColor, KHR_materials_scatter, multiscatterColor, xyz, Srgb, ThinScatter,
                         kShare)
RAYGRAPH_MATERIAL_NUMBER(float, scatterMeanCosine, scatterMeanCosine, KHR_materials_scatter,
                         scatterAnisotropy, ThinScatter, kMeanCosine)

RAYGRAPH_MATERIAL_FLAG(isSpecularGlossiness, KHR_materials_pbrSpecularGlossiness)
RAYGRAPH_MATERIAL_VALUE(uint, priority, priority, extras, priority, kNoNumber)

#undef RAYGRAPH_MATERIAL_FACTOR
#undef RAYGRAPH_MATERIAL_NUMBER
#undef RAYGRAPH_MATERIAL_VALUE
#undef RAYGRAPH_MATERIAL_TEXTURE
#undef RAYGRAPH_MATERIAL_FIELD
#undef RAYGRAPH_MATERIAL_FLAG
#undef RAYGRAPH_MATERIAL_UNSHOWN
