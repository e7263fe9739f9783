// The features of the integrator that a scene needs. A bit that is off removes its code, which saves time on
// a device and, on a CPU device, seconds of compilation. trace_options.h alone includes this list, once for
// each meaning of RAYGRAPH_TRACE_FEATURE(Name, Kind). A feature's bit is the number of its line (modulo 64):
// a row has a line of its own, new rows come last, and nothing else goes above them, or shaders that are
// loaded from a folder at run time have other bits than the program.
RAYGRAPH_TRACE_FEATURE(LightSampling, Lights)
RAYGRAPH_TRACE_FEATURE(TriangleLights, Lights)
RAYGRAPH_TRACE_FEATURE(PunctualLights, Lights)
RAYGRAPH_TRACE_FEATURE(EnvironmentLight, Lights)
RAYGRAPH_TRACE_FEATURE(LightProfiles, Lights)
RAYGRAPH_TRACE_FEATURE(Textures, Textures)
RAYGRAPH_TRACE_FEATURE(TextureTransforms, Textures)
RAYGRAPH_TRACE_FEATURE(VertexColors, Textures)
RAYGRAPH_TRACE_FEATURE(Glass, Lobes)
RAYGRAPH_TRACE_FEATURE(Metals, Lobes)
RAYGRAPH_TRACE_FEATURE(Opaque, Lobes)
RAYGRAPH_TRACE_FEATURE(Clearcoat, Lobes)
RAYGRAPH_TRACE_FEATURE(Sheen, Lobes)
RAYGRAPH_TRACE_FEATURE(Smooth, Lobes)
RAYGRAPH_TRACE_FEATURE(Anisotropy, Lobes)
RAYGRAPH_TRACE_FEATURE(Iridescence, Lobes)
RAYGRAPH_TRACE_FEATURE(Dispersion, Lobes)
RAYGRAPH_TRACE_FEATURE(DiffuseTransmission, Lobes)
RAYGRAPH_TRACE_FEATURE(Retroreflection, Lobes)
RAYGRAPH_TRACE_FEATURE(Scattering, Lobes)
RAYGRAPH_TRACE_FEATURE(MatchedMedia, Lobes)
RAYGRAPH_TRACE_FEATURE(Volumes, Media)
RAYGRAPH_TRACE_FEATURE(ProbeMedia, Media)
RAYGRAPH_TRACE_FEATURE(MeshLights, Hits)
RAYGRAPH_TRACE_FEATURE(ThinWalls, Hits)
RAYGRAPH_TRACE_FEATURE(Capsules, Hits)
RAYGRAPH_TRACE_FEATURE(AnyHit, Hits)
RAYGRAPH_TRACE_FEATURE(ShadowTerminator, Settings)
RAYGRAPH_TRACE_FEATURE(TextureLod, Settings)
RAYGRAPH_TRACE_FEATURE(HiddenEnvironment, Settings)
RAYGRAPH_TRACE_FEATURE(PixelList, Settings)
RAYGRAPH_TRACE_FEATURE(ThinScatter, Lobes)
RAYGRAPH_TRACE_FEATURE(ShadowCatcher, Hits)

// Lights: light sampling.
//   LightSampling:    lights are sampled, of which there are
//   TriangleLights, PunctualLights, EnvironmentLight
//   LightProfiles:    some punctual lights have one
// Textures: what surfaces read.
//   Textures:         materials have textures
//   TextureTransforms: some are read elsewhere than at the primitive's texture coordinates, or along other
//                     axes than its tangents
//   VertexColors:     some vertices have a color
// Lobes: what materials scatter.
//   Glass, Metals, Opaque, Clearcoat, Sheen: materials have these lobes (bxdf/gltf_lobes.glsl): they transmit
//                     light, are metal, are a layer over a diffuse base, have a clear coat, have sheen
//   Smooth:           some materials or coats reflect in a single direction
//   Anisotropy:       highlights of some materials are stretched
//   Iridescence:      some are under a thin film
//   Dispersion:       some glass refracts colors differently
//   DiffuseTransmission: some opaque ones scatter light to their other side
//   Retroreflection:  facets of some materials reflect light back to where it came from
//   ThinScatter:      some surfaces without a medium scatter what they would transmit
//   Scattering:       some media scatter
//   MatchedMedia:     light goes straight on into and out of some, of the index of what is around them
// Media:
//   Volumes:          surfaces enclose media
//   ProbeMedia:       the camera may be inside of some
// Hits: what rays meet.
//   MeshLights:       some triangle lights are those of a mesh that is placed often
//   ThinWalls:        light goes straight on through some surfaces
//   Capsules:         some primitives are round
//   AnyHit:           some surfaces are there or not to a ray as an any-hit shader says
//   ShadowCatcher:    of some surfaces the camera sees the shadow alone, where the environment is hidden
// Settings: biases that change what a surface is, the camera, and the samples.
//   ShadowTerminator: opaque surfaces are where their vertex normals bend them to (scene/surface.glsl)
//   TextureLod:       textures are read at a level that fits the path's cone (core/ray_cone.glsl), or, by
//                     passes over pixels, the pixel's footprint (raster/pixel_footprint.glsl)
//   HiddenEnvironment: the camera does not see the environment
//   PixelList:        samples are of the pixels of a list (passes/pixel_list.h), not of all
