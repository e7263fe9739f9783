// PassBuilder: the declarations of a pass, made in its setup function. Everything is checked when the setup
// returns: names, kinds and writability against the shaders' SPIR-V, ids against the frame. A mistake throws
// Error{Usage} that names the pass, the resource, what was asked and what the shader has.
//
//   TextureId Blur(Renderer& r, TextureId source) {
//       TextureId blurred = r.CreateTexture("blurred", r.Desc(source));
//       r.AddPass("Blur", PassKind::Compute,
//           [&](PassBuilder& pass) {                    // runs now: capture by reference
//               pass.Compute("post/blur.comp");
//               pass.Reads("source", source);
//               blurred = pass.Writes("blurred", blurred);
//           },
//           [extent](CommandList& cmd) { cmd.DispatchOver(extent); });   // runs later: capture by value
//       return blurred;
//   }
//
// Threads: that of the Renderer; a PassBuilder lives as long as the setup function runs.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/api.h"
#include "renderer/graph/access.h"
#include "renderer/graph/frame_graph.h"
#include "renderer/graph/ids.h"
#include "rhi/pipeline.h"
#include "rhi/resources.h"
#include "shaders/shared/ray_types.h"

namespace raygraph {

class Renderer;
class ShaderLibrary;
struct PassDeclaration;
struct Shader;
enum class BindVerb : uint8_t;

// Holds the names of the shaders of one hit group; "" leaves the stage out.
struct HitGroupShaders {
    std::string_view closestHit;
    std::string_view anyHit;
    std::string_view intersection;
};

// Holds the drawing state of a raster pass; the formats come from its targets.
struct RasterState {
    rhi::Topology topology = rhi::Topology::TriangleList;
    rhi::CullMode cull = rhi::CullMode::None;
    bool isFrontClockwise = false;
    rhi::DepthCompare depthCompare = rhi::DepthCompare::LessOrEqual;
    bool writesDepth = true;
    rhi::BlendMode blend = rhi::BlendMode::Off;
    bool isWireframe = false;

    bool operator==(const RasterState&) const = default;
};

struct ColorLoad {
    bool clear = true;  // false: load, and blend over the old contents
    float value[4] = {0.0f, 0.0f, 0.0f, 0.0f};
};
struct DepthLoad {
    bool clear = true;
    float value = 1.0f;
};

class RAYGRAPH_API PassBuilder {
  public:
    // --- Shaders, by their name in the ShaderLibrary ("pathtrace/pathtrace.rgen") ---
    PassBuilder& RayGen(std::string_view shader);
    PassBuilder& Miss(RayType rayType, std::string_view shader);
    // `hitSet` distinguishes instances (FirstHitRecord); there is one group per ray type in each set. Where a
    // set is not given a group, it has that of set 0 if it is even, and of set 1 if it is odd: those of the
    // same kind of primitives (HitSetOf).
    PassBuilder& HitGroup(RayType rayType, const HitGroupShaders& shaders, uint32_t hitSet = 0);
    PassBuilder& Callable(std::string_view shader);
    // Sets how deep rays may trace rays. With 1, the default, only ray generation traces; a closest-hit
    // shader that traces needs one more. A depth of 0 or above the device's maxRayRecursionDepth is an error;
    // tracing more deeply than this is undefined behavior.
    PassBuilder& MaxRecursion(uint32_t depth);
    PassBuilder& Compute(std::string_view shader);
    PassBuilder& Vertex(std::string_view shader);
    PassBuilder& Fragment(std::string_view shader);
    PassBuilder& Raster(const RasterState& state);
    // Sets a specialization constant by its name in the shaders; a name that no stage declares is an error.
    PassBuilder& Specialize(std::string_view constant, uint32_t value);

    // --- Resources bound by name (set 0) ---
    // The last argument is a part of a texture: Level(1), Layers(0, 6), Subresource(1, 3), or by default all
    // of it. A storage image is one level. The shader declares how many layers it sees: one as image2D or
    // sampler2D, six as cube map, any number as array. An element of an array of resources is bound by its
    // name in GLSL, "shadowMaps[2]", and each needs one. A pass may read one part and write another one that
    // does not overlap: `pass.Reads("finer", chain, Level(0)); chain = pass.Writes("coarser", chain,
    // Level(1));`.
    void Reads(std::string_view name, TextureId texture, const Subresources& part = {});  // storage image
    void Reads(std::string_view name, TextureId texture, const rhi::SamplerDesc& sampler) {
        Reads(name, texture, Subresources{}, sampler);
    }
    void Reads(std::string_view name, TextureId texture, const Subresources& part,
               const rhi::SamplerDesc& sampler);
    void Reads(std::string_view name, BufferId buffer);  // storage or uniform, as the shader declares it
    void Reads(std::string_view name, TlasId tlas);
    // Writes does not need the earlier contents; Updates reads them, too.
    [[nodiscard]] TextureId Writes(std::string_view name, TextureId texture, const Subresources& part = {});
    [[nodiscard]] BufferId Writes(std::string_view name, BufferId buffer);
    [[nodiscard]] TextureId Updates(std::string_view name, TextureId texture, const Subresources& part = {});
    [[nodiscard]] BufferId Updates(std::string_view name, BufferId buffer);

    // --- Resources without a binding ---
    void ReadsByAddress(BufferId buffer);
    void ReadsByAddress(BlasSetId structures);  // referenced by the traced TLAS
    [[nodiscard]] BufferId WritesByAddress(BufferId buffer);
    void Uses(TextureSetId textures);      // bindless, set 1
    void ReadsArguments(BufferId buffer);  // arguments of an indirect dispatch, trace or draw
    void ReadsIndices(BufferId buffer);    // indices of DrawIndexed

    // --- Attachments of a raster pass, one level each; depth has no index ---
    // With several layers, of which all targets have as many, the vertex shader writes the one to draw to,
    // from 0, to gl_Layer (GL_ARB_shader_viewport_layer_array). The device needs
    // OptionalFeatures::layeredTargets then.
    [[nodiscard]] TextureId ColorTarget(uint32_t index, TextureId texture, const ColorLoad& load = {}) {
        return ColorTarget(index, texture, Subresources{}, load);
    }
    [[nodiscard]] TextureId ColorTarget(uint32_t index, TextureId texture, const Subresources& part,
                                        const ColorLoad& load = {});
    [[nodiscard]] TextureId DepthTarget(TextureId texture, const DepthLoad& load = {}) {
        return DepthTarget(texture, Subresources{}, load);
    }
    [[nodiscard]] TextureId DepthTarget(TextureId texture, const Subresources& part,
                                        const DepthLoad& load = {});

    // --- Transfer and acceleration-structure passes ---
    void CopiesFrom(TextureId texture, const Subresources& part = {});
    void CopiesFrom(BufferId buffer);
    [[nodiscard]] TextureId CopiesTo(TextureId texture, const Subresources& part = {});
    [[nodiscard]] BufferId CopiesTo(BufferId buffer);
    void BuildsFrom(BufferId input);
    void BuildsFrom(BlasSetId structures);
    [[nodiscard]] TlasId Builds(TlasId tlas);
    [[nodiscard]] BlasSetId Builds(BlasSetId structures);
    [[nodiscard]] TlasId Refits(TlasId tlas);
    [[nodiscard]] BlasSetId Refits(BlasSetId structures);

    // --- Constants, which are copied by these calls ---
    // Sets the push constants; the size must equal that of the shaders' block.
    template <typename T>
    void Constants(const T& constants) {
        static_assert(std::is_trivially_copyable_v<T>);
        ConstantBytes(std::as_bytes(std::span(&constants, 1)), alignof(T));
    }
    // Sets a uniform block of set 0, in the frame's uniform memory.
    template <typename T>
    void Uniform(std::string_view name, const T& data) {
        static_assert(std::is_trivially_copyable_v<T>);
        UniformBytes(name, std::as_bytes(std::span(&data, 1)), alignof(T));
    }
    // Does so with data whose layout is known only when the program runs. Of a size that `alignment` has
    // rounded up, the last bytes may be missing in the shaders' block.
    void ConstantBytes(std::span<const std::byte> bytes, size_t alignment = 1);
    void UniformBytes(std::string_view name, std::span<const std::byte> bytes, size_t alignment = 1);

    // A PassSeries may divide the pass, as it does with all compute passes: `execute` covers the rows, or
    // whatever else there is many of, that CommandList::PortionOf returns.
    void Dividable();
    // The pass may run on the device's compute queue, beside passes that it does not depend on. Drawing
    // passes, devices without that queue and frames for Record ignore this. A transfer pass must not blit or
    // touch depth then. It pays for passes that leave much of the device idle; each change of the queue costs
    // a submission.
    void AsyncCompute();
    // The pass has an effect that the graph cannot see, and is never culled.
    void KeepAlive();

  private:
    friend class Renderer;
    PassBuilder(Renderer& renderer, FrameGraph& graph, ShaderLibrary& shaders, PassDeclaration& pass)
        : m_renderer(renderer), m_graph(graph), m_shaders(shaders), m_pass(pass) {}
    const Shader* FindShader(std::string_view name);
    template <ResourceKind Kind>
    ResourceId<Kind> Bind(std::string_view name, ResourceId<Kind> id, BindVerb verb, Access access,
                          const rhi::Sampler* sampler = nullptr, const Subresources& part = {});

    Renderer& m_renderer;
    FrameGraph& m_graph;
    ShaderLibrary& m_shaders;
    PassDeclaration& m_pass;
};

}  // namespace raygraph
