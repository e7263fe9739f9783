// Buffers that shaders reach by the addresses of a uniform block, which the graph fills in.
#include "tests/graph/graph_test.h"

namespace raygraph::address_table_test {
namespace {

class AddressTableFrame : public GraphTest {
  protected:
    AddressTableFrame() {
        AddShader("test/start.comp", "void main() { sums.at[1] = constants.value; }");
        AddShader("test/table.comp", "void main() { sums.at[0] = constants.value + source.at[1]; }");
    }

    BufferId Run(const char* pass, const char* shader, BufferId source, float value) {
        BufferId sums = m_renderer.CreateBuffer(pass, {.size = 8});
        m_renderer.AddPass(
            pass, PassKind::Compute,
            [&](PassBuilder& builder) {
                builder.Compute(shader);
                if (source.IsValid()) builder.Reads("source", source);
                sums = builder.Writes("sums", sums);
                builder.Constants(value);
            },
            [](CommandList& commands) { commands.Dispatch(1, 1, 1); });
        return sums;
    }

  private:
    void AddShader(const char* name, const char* main) {
        constexpr std::string_view kTables = R"(
#extension GL_EXT_buffer_reference : require
layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Source { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Sums { float at[]; };
layout(push_constant, std430) uniform Constants { float value; } constants;
layout(binding = 1, scalar) uniform Tables { Source source; Source unused; Sums sums; };
)";
        m_renderer.AddShader(name, CompileText(name, std::string(kTables) + main));
    }
};

// The second pass waits for the first: a name in a table declares the access as a binding does.
TEST_F(AddressTableFrame, BuffersAreReadAndWrittenFrameAfterFrame) {
    for (const float value : {1.0f, 3.0f, 5.0f, 7.0f}) {
        m_renderer.BeginFrame();
        const BufferId start = Run("Start", "test/start.comp", {}, value);
        const BufferId sum = Run("Add", "test/table.comp", start, value);
        const Readback readback = m_renderer.ReadBack(sum);
        m_renderer.Execute();
        readback.Wait();
        EXPECT_EQ(testing::As<float>(readback.Bytes())[0], 2.0f * value);
    }
}

}  // namespace
}  // namespace raygraph::address_table_test
