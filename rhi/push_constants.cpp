#include "rhi/push_constants.h"

#include <optional>
#include <spirv_cross.hpp>

namespace raygraph::rhi {
namespace {

std::optional<ConstantType> TypeOf(const spirv_cross::SPIRType& type) {
    switch (type.basetype) {
        case spirv_cross::SPIRType::Float:
            return ConstantType::Float;
        case spirv_cross::SPIRType::Int:
            return ConstantType::Int;
        case spirv_cross::SPIRType::UInt:
            return ConstantType::Uint;
        case spirv_cross::SPIRType::Boolean:
            return ConstantType::Bool;
        default:
            return std::nullopt;
    }
}

}  // namespace

std::vector<BlockMember> PushConstantMembers(std::span<const uint32_t> spirv) {
    const spirv_cross::Compiler compiler(spirv.data(), spirv.size());
    std::vector<BlockMember> members;
    for (const auto& resource : compiler.get_shader_resources().push_constant_buffers) {
        const spirv_cross::SPIRType& block = compiler.get_type(resource.base_type_id);
        for (uint32_t i = 0; i < block.member_types.size(); ++i) {
            const spirv_cross::SPIRType& type = compiler.get_type(block.member_types[i]);
            const std::optional<ConstantType> known = TypeOf(type);
            const bool isVector = known && type.width == 32 && type.columns == 1 && type.array.empty();
            members.push_back({.name = compiler.get_member_name(resource.base_type_id, i),
                               .offset = compiler.type_struct_member_offset(block, i),
                               .type = known.value_or(ConstantType::Float),
                               .count = isVector ? type.vecsize : 0});
        }
    }
    return members;
}

}  // namespace raygraph::rhi
