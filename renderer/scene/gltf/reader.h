// Readers of values in a glTF file: AccessorReader decodes accessors to floats and indices, ValueReader
// reads the properties of extensions. Internal to renderer/scene.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/model.h"

namespace raygraph::scene {

// Selects the elements of an accessor to read, and their order: all, or those listed (all below the count).
struct ElementSelection {
    size_t count = 0;
    const uint32_t* ids = nullptr;  // nullptr: 0 to count - 1
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

    // Returns the bytes of a view.
    std::span<const std::byte> View(uint32_t view) { return m_buffers.View(view); }
    const AccessorTables& Tables() const { return m_tables; }

    // Returns all elements of an accessor of unsigned scalars, which the caller has made sure it is. `where`
    // (the property that names it) is for messages.
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

// Reads the properties of an object of an extension, which tinygltf keeps as a value of the types that the
// schema has checked. Threads: exclusive access to the model.
class ValueReader {
  public:
    // A null object stands for an absent one, which has no members.
    explicit ValueReader(const gltf::Value* object) : m_object(object) {}
    ValueReader(const gltf::ExtensionMap& extensions, const char* name) {
        if (const auto found = extensions.find(name); found != extensions.end()) m_object = &found->second;
    }

    explicit operator bool() const { return m_object != nullptr; }

    // Return a reader of one of the object's members, and of an element of a list.
    ValueReader In(const std::string& object) const {
        return ValueReader(m_object && m_object->Has(object) ? &m_object->Get(object) : nullptr);
    }
    ValueReader operator[](size_t index) const {
        return ValueReader(&m_object->Get(static_cast<int>(index)));
    }

    // These leave `value` as it is if the key is absent.
    void Read(const std::string& key, int& value) const {
        if (const ValueReader found = In(key)) value = found.m_object->GetNumberAsInt();
    }
    void Read(const std::string& key, double& value) const {
        if (const ValueReader found = In(key)) value = found.m_object->GetNumberAsDouble();
    }
    void Read(const std::string& key, float& value) const {
        if (const ValueReader found = In(key))
            value = static_cast<float>(found.m_object->GetNumberAsDouble());
    }
    void Read(const std::string& key, std::string& value) const {
        if (const ValueReader found = In(key)) value = found.m_object->Get<std::string>();
    }
    template <int Length>
    void Read(const std::string& key, glm::vec<Length, float>& value) const {
        if (const ValueReader found = In(key))
            for (int i = 0; i < Length; ++i)
                value[i] = static_cast<float>(found.m_object->Get(i).GetNumberAsDouble());
    }

  private:
    const gltf::Value* m_object = nullptr;
};

}  // namespace raygraph::scene
