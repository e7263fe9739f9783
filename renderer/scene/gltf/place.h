// A place in a glTF document, for messages. Internal to renderer/scene.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace raygraph::scene {

// A place in the document. It is cheap to make and to pass on: the text is made when a message needs it.
class Place {
  public:
    // The document itself, whose path is empty.
    Place() = default;
    // Names must be literals: they are kept.
    explicit Place(const char* name) { Add({name, 0}); }

    Place operator[](const char* name) const { return Below({name, 0}); }
    Place operator[](size_t index) const { return Below({nullptr, index}); }

    // Returns the path, such as "accessors[3].count".
    std::string Path() const;
    operator std::string() const { return Path(); }

  private:
    struct Step {
        const char* name = nullptr;  // nullptr: an array index
        size_t index = 0;
    };

    void Add(const Step& step) {
        if (m_count < m_steps.size()) m_steps[m_count++] = step;
    }
    Place Below(const Step& step) const {
        Place place = *this;
        place.Add(step);
        return place;
    }

    uint32_t m_count = 0;
    // The importer reads nothing deeper; a deeper place keeps the path of its container.
    std::array<Step, 8> m_steps;
};

}  // namespace raygraph::scene
