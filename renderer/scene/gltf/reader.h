// Decodes accessors to floats and indices. Internal to renderer/scene.
#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/buffers.h"
#include "renderer/scene/gltf/context.h"

namespace raygraph::scene {

// Selects the elements of an accessor to read, and their order: all, or those listed (all below the count).
struct ElementSelection {
    size_t count = 0;
    const uint32_t* ids = nullptr;  // nullptr: 0 to count - 1.
    // The places in the selection whose elements a picture depends on; nullptr: all.
    const std::vector<uint32_t>* used = nullptr;

    size_t operator[](size_t i) const { return ids ? ids[i] : i; }
    // Returns, for each place in the selection, whether it is used.
    std::vector<bool> UsedElements() const;
};

class AccessorReader {
  public:
    // All arguments must outlive this object.
    AccessorReader(GltfContext& context, const AccessorTables& tables, GltfBuffers& buffers)
        : m_context(context), m_tables(tables), m_buffers(buffers) {}

    const Accessor& Info(uint32_t accessor) const { return m_tables.accessors[accessor]; }

    // The selected elements, `components` floats each, into `out` (selection.count * components floats); an
    // accessor with fewer components leaves the others of each element as they were. Normalized integers
    // become [0, 1] or [-1, 1], others their value. Of matrices only those of floats. `packed`: all elements,
    // in place of those that the accessor's view or sparse part has. Fails at the accessor if a value is not
    // finite; where no used element has it, the element becomes the first used one, or without one what the
    // first was in `out`, with a warning.
    void Read(uint32_t accessor, const ElementSelection& selection, size_t components, float* out,
              std::span<const std::byte> packed = {});
    // Likewise, of all elements; returns the first that is not finite, and leaves it so.
    std::optional<size_t> ReadAny(uint32_t accessor, size_t components, float* out);

    template <typename Vector>
    std::vector<Vector> ReadVectors(uint32_t accessor, const ElementSelection& selection, const Place& where,
                                    Vector fill = Vector(0.0f), std::span<const std::byte> packed = {}) {
        m_context.ChargeGeometry(where, uint64_t{selection.count} * sizeof(Vector));
        std::vector<Vector> vectors(selection.count, fill);
        if (!vectors.empty()) Read(accessor, selection, Vector::length(), &vectors[0].x, packed);
        return vectors;
    }

    // The bytes of a view.
    std::span<const std::byte> View(uint32_t view) { return m_buffers.View(view); }
    const AccessorTables& Tables() const { return m_tables; }

    // All elements of an accessor of unsigned scalars, which the caller has made sure it is. `where` (the
    // property that names it) is for messages.
    std::vector<uint32_t> ReadIndices(uint32_t accessor, const Place& where);

  private:
    void Copy(uint32_t accessor, const ElementSelection& selection, size_t components, float* out,
              std::span<const std::byte> packed);
    const std::byte* RunBytes(const ElementRun& run);
    std::vector<uint32_t> SparseIndices(uint32_t accessor);
    void ApplySparse(uint32_t accessor, const ElementSelection& selection, size_t components, float* out);

    GltfContext& m_context;
    const AccessorTables& m_tables;
    GltfBuffers& m_buffers;
};

}  // namespace raygraph::scene
