#include "renderer/scene/gltf/reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/check.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

// Describes a run of elements in memory. `bytes` may be unaligned.
struct Elements {
    const std::byte* bytes = nullptr;
    size_t stride = 0;
    size_t componentCount = 0;
    bool isNormalized = false;
};

// Follows glTF's section 3.11 for the integer types.
template <typename T>
float ToFloat(T value, bool isNormalized) {
    const float number = static_cast<float>(value);
    if constexpr (std::is_integral_v<T>) {
        if (isNormalized) return std::max(number / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
    }
    return number;
}

template <typename T>
void CopyElement(const Elements& from, size_t element, float* out) {
    const std::byte* bytes = from.bytes + element * from.stride;
    for (size_t c = 0; c < from.componentCount; ++c) {
        T value;
        std::memcpy(&value, bytes + c * sizeof(T), sizeof(T));
        out[c] = ToFloat(value, from.isNormalized);
    }
}

template <typename T>
void CopyAll(const Elements& from, const ElementSelection& selection, size_t components, float* out) {
    for (size_t i = 0; i < selection.count; ++i) CopyElement<T>(from, selection[i], out + i * components);
}

// Calls `call` with a value of the component's C++ type.
template <typename Call>
void WithType(ComponentType type, const Call& call) {
    switch (type) {
        case ComponentType::Int8:
            return call(int8_t{});
        case ComponentType::Uint8:
            return call(uint8_t{});
        case ComponentType::Int16:
            return call(int16_t{});
        case ComponentType::Uint16:
            return call(uint16_t{});
        case ComponentType::Uint32:
            return call(uint32_t{});
        case ComponentType::Float:
            return call(float{});
    }
}

// Copies elements of an unsigned type T.
template <typename T>
void CopyIntegers(const std::byte* bytes, size_t stride, std::vector<uint32_t>& out) {
    for (size_t i = 0; i < out.size(); ++i) {
        T value;
        std::memcpy(&value, bytes + i * stride, sizeof(T));
        out[i] = value;
    }
}

bool IsFinite(const float* element, size_t components) {
    return std::all_of(element, element + components, [](float value) { return std::isfinite(value); });
}

void CopyIndices(ComponentType type, const std::byte* bytes, size_t stride, std::vector<uint32_t>& out) {
    RG_CHECK(type == ComponentType::Uint8 || type == ComponentType::Uint16 || type == ComponentType::Uint32);
    if (type == ComponentType::Uint8) CopyIntegers<uint8_t>(bytes, stride, out);
    if (type == ComponentType::Uint16) CopyIntegers<uint16_t>(bytes, stride, out);
    if (type == ComponentType::Uint32) CopyIntegers<uint32_t>(bytes, stride, out);
}

}  // namespace

std::vector<bool> ElementSelection::UsedElements() const {
    std::vector<bool> isUsed(count, used == nullptr);
    if (used)
        for (const uint32_t place : *used) isUsed[place] = true;
    return isUsed;
}

const std::byte* AccessorReader::RunBytes(const ElementRun& run) {
    return m_buffers.View(run.view).data() + run.byteOffset;
}

void AccessorReader::Read(uint32_t accessor, const ElementSelection& selection, size_t components, float* out,
                          std::span<const std::byte> packed) {
    RG_CHECK_LE(components, size_t{16});
    std::array<float, 16> fill{};
    if (selection.count > 0) std::copy_n(out, components, fill.begin());
    Copy(accessor, selection, components, out, packed);
    if (Info(accessor).componentType != ComponentType::Float || IsFinite(out, selection.count * components))
        return;
    const Place where = Place("accessors")[accessor];
    const std::vector<bool> isUsed = selection.UsedElements();
    const float* const instead =
        selection.used && !selection.used->empty() ? out + selection.used->front() * components : fill.data();
    // Used elements come first: what is copied is then finite
    for (const bool isForUsed : {true, false})
        for (size_t i = 0; i < selection.count; ++i) {
            float* const element = out + i * components;
            if (isUsed[i] != isForUsed || IsFinite(element, components)) continue;
            if (isForUsed) m_context.Fail(where, Text("element {} is not finite", selection[i]));
            m_context.Warn(
                where, "unused element",
                Text("element {} is not finite, and no picture depends on it; replaced", selection[i]));
            std::copy_n(instead, components, element);
        }
}

std::optional<size_t> AccessorReader::ReadAny(uint32_t accessor, size_t components, float* out) {
    const size_t count = Info(accessor).count;
    Copy(accessor, {count}, components, out, {});
    if (Info(accessor).componentType != ComponentType::Float) return std::nullopt;
    for (size_t i = 0; i < count; ++i)
        if (!IsFinite(out + i * components, components)) return i;
    return std::nullopt;
}

void AccessorReader::Copy(uint32_t accessor, const ElementSelection& selection, size_t components, float* out,
                          std::span<const std::byte> packed) {
    const Accessor& info = Info(accessor);
    RG_CHECK_LE(info.componentCount, components);
    RG_CHECK(!info.isMatrix || info.componentType == ComponentType::Float);  // whose columns have no padding
    if (!packed.empty() || info.run.view != kNone) {
        Elements elements{packed.data(), info.componentCount * ByteSize(info.componentType),
                          info.componentCount, info.isNormalized};
        if (packed.empty()) {
            elements.bytes = RunBytes(info.run);
            elements.stride = info.run.byteStride;
        }
        const bool isPlain = info.componentType == ComponentType::Float &&
                             info.componentCount == components &&
                             elements.stride == components * sizeof(float) && !selection.ids;
        if (isPlain) {
            std::memcpy(out, elements.bytes, selection.count * elements.stride);
        } else {
            WithType(info.componentType,
                     [&](auto type) { CopyAll<decltype(type)>(elements, selection, components, out); });
        }
    } else {
        for (size_t i = 0; i < selection.count; ++i)
            std::fill_n(out + i * components, info.componentCount, 0.0f);
    }
    if (info.sparse && packed.empty()) ApplySparse(accessor, selection, components, out);
}

std::vector<uint32_t> AccessorReader::SparseIndices(uint32_t accessor) {
    const Accessor& info = Info(accessor);
    const Place where = Place("accessors")[accessor]["sparse"]["indices"];
    m_context.ChargeGeometry(where, info.sparse->count * sizeof(uint32_t));
    std::vector<uint32_t> ids(info.sparse->count);
    const ElementRun& run = info.sparse->indices;
    CopyIndices(info.sparse->indexType, RunBytes(run), run.byteStride, ids);
    for (size_t i = 0; i < ids.size(); ++i) {
        if (ids[i] >= info.count)
            m_context.Fail(where, Text("element {} is {}, but the accessor has {}", i, ids[i],
                                       Counted(info.count, "element")));
        if (i > 0 && ids[i] <= ids[i - 1])
            m_context.Fail(where, Text("element {} is {}, not greater than the one before it", i, ids[i]));
    }
    return ids;
}

void AccessorReader::ApplySparse(uint32_t accessor, const ElementSelection& selection, size_t components,
                                 float* out) {
    const Accessor& info = Info(accessor);
    const std::vector<uint32_t> ids = SparseIndices(accessor);
    const Elements values{RunBytes(info.sparse->values), info.sparse->values.byteStride, info.componentCount,
                          info.isNormalized};
    WithType(info.componentType, [&](auto type) {
        using T = decltype(type);
        if (!selection.ids) {
            for (size_t i = 0; i < ids.size(); ++i) CopyElement<T>(values, i, out + ids[i] * components);
            return;
        }
        for (size_t i = 0; i < selection.count; ++i) {
            const auto found = std::lower_bound(ids.begin(), ids.end(), selection.ids[i]);
            if (found != ids.end() && *found == selection.ids[i])
                CopyElement<T>(values, static_cast<size_t>(found - ids.begin()), out + i * components);
        }
    });
}

std::vector<uint32_t> AccessorReader::ReadIndices(uint32_t accessor, const Place& where) {
    const Accessor& info = Info(accessor);
    RG_CHECK_EQ(info.componentCount, 1u);
    m_context.ChargeGeometry(where, info.count * sizeof(uint32_t));
    std::vector<uint32_t> indices(info.count);
    const auto copy = [&](const ElementRun& run, std::vector<uint32_t>& out) {
        CopyIndices(info.componentType, RunBytes(run), run.byteStride, out);
    };
    if (info.run.view != kNone) copy(info.run, indices);
    if (info.sparse) {
        const std::vector<uint32_t> ids = SparseIndices(accessor);
        std::vector<uint32_t> values(ids.size());
        copy(info.sparse->values, values);
        for (size_t i = 0; i < ids.size(); ++i) indices[ids[i]] = values[i];
    }
    return indices;
}

}  // namespace raygraph::scene
