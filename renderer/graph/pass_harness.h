// PassHarness: runs one pass alone: constructed inputs in, texels out. For tests of passes, also outside of
// this repository.
//
//   PassHarness harness(device);
//   const Texels out = harness.Run([&](PassHarness& h) {
//       TextureId radiance = h.Texture("radiance", {2, 1}, Format::Rgba32Float, {1, 0, 0, 1,   0, 4, 0, 1});
//       return Tonemap(h.Graph(), radiance, settings);
//   });
//   EXPECT_NEAR(out.At(0, 0)[0], 1.0f, 1e-6f);
//
// Each Run is a frame of one Renderer, so that persistent resources keep their contents from Run to Run. Uses
// no test framework; every failure is an Error, and the next Run starts clean. Threads: one thread at a time;
// harnesses of several threads may share a Device.
#pragma once

#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::testing {

// Describes a texture on the CPU: rows from the top, `channelCount` floats per texel. Unorm formats are
// scaled to [0, 1] (sRGB is not decoded), and integers are converted.
struct RAYGRAPH_API Texels {
    Extent2D extent;
    uint32_t channelCount = 0;
    std::vector<float> values;

    // Returns the channels of one texel; throws Error{Usage} outside of the extent.
    std::span<const float> At(uint32_t x, uint32_t y) const;
};

// These convert bytes of a texture to floats, and back (rounded and clamped to the range of the format). They
// throw Error{Usage} when sizes disagree.
RAYGRAPH_API Texels DecodeTexels(std::span<const std::byte> bytes, Extent2D extent, rhi::Format format);
RAYGRAPH_API std::vector<std::byte> EncodeTexels(std::span<const float> values, Extent2D extent,
                                                 rhi::Format format);
// Returns 1 to 4; 0 for Undefined.
RAYGRAPH_API uint32_t ChannelCount(rhi::Format format);

class RAYGRAPH_API PassHarness {
  public:
    explicit PassHarness(rhi::Device& device, const RendererDesc& desc = {});

    Renderer& Graph() { return m_renderer; }

    // Creates an input of the current frame: a transient that an upload pass fills. `values` holds the
    // channels of every texel, rows from the top; the channels of a single texel fill the whole texture.
    TextureId Texture(std::string_view name, Extent2D extent, rhi::Format format,
                      std::span<const float> values);
    TextureId Texture(std::string_view name, Extent2D extent, rhi::Format format,
                      std::initializer_list<float> values) {
        return Texture(name, extent, format, std::span(values.begin(), values.size()));
    }
    // Creates a texture of several levels and layers: `values` holds layer after layer, each from level 0 on.
    TextureId Texture(std::string_view name, const GraphTextureDesc& desc, std::span<const float> values);
    BufferId Buffer(std::string_view name, std::span<const std::byte> bytes);
    template <typename T>
    BufferId Buffer(std::string_view name, const std::vector<T>& values) {
        return Buffer(name, std::as_bytes(std::span(values)));
    }

    // Declares a frame, executes it, waits, and returns the contents of the declared id at its end.
    Texels Run(const std::function<TextureId(PassHarness&)>& declare);
    // Returns all levels of all layers: layer after layer, each from level 0 on. Run reads only the first
    // level of the first layer.
    std::vector<Texels> RunAll(const std::function<TextureId(PassHarness&)>& declare);
    template <typename T>
    std::vector<T> RunBuffer(const std::function<BufferId(PassHarness&)>& declare) {
        const std::vector<std::byte> bytes = RunBytes(declare);
        std::vector<T> values(bytes.size() / sizeof(T));
        std::copy_n(bytes.begin(), values.size() * sizeof(T),
                    std::as_writable_bytes(std::span(values)).begin());
        return values;
    }
    // Returns the plan of the last Run.
    std::string Plan() const { return m_renderer.DescribePlan(); }

  private:
    std::vector<std::byte> RunBytes(const std::function<BufferId(PassHarness&)>& declare);

    Renderer m_renderer;
};

}  // namespace raygraph::testing
