// The bytes behind buffer views, opened when first asked for. Internal to renderer/scene.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/context.h"

namespace raygraph::scene {

class GltfBuffers {
  public:
    // All arguments must outlive this object.
    GltfBuffers(GltfContext& context, const std::vector<BufferSource>& sources, const AccessorTables& tables,
                const GltfContainer& container);

    // The bytes of a view, decoded if they are compressed; they live as long as this object. Fails if its
    // buffer cannot be read or is shorter than it claims.
    std::span<const std::byte> View(uint32_t view);

  private:
    std::span<const std::byte> Buffer(uint32_t buffer);

    GltfContext& m_context;
    const std::vector<BufferSource>& m_sources;
    const AccessorTables& m_tables;
    const GltfContainer& m_container;
    std::vector<std::optional<std::vector<std::byte>>> m_files;    // those not in the .glb
    std::vector<std::optional<std::vector<std::byte>>> m_decoded;  // By view.
};

}  // namespace raygraph::scene
