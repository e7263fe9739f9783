// Reads the properties of an object of an extension, which tinygltf keeps as a value of the types that the
// schema has checked. Internal to renderer/scene. Threads: exclusive access to the model.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <string>

#include "renderer/scene/gltf/model.h"

namespace raygraph::scene {

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
