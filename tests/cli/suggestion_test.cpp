#include "editor/cli/command_tree.h"

#include "editor/cli/arguments.h"
#include "tests/cli/cli_test.h"

namespace raygraph::cli::suggestion_test {
namespace {

TEST(Suggestion, CountsWhatIsWrong) {
    EXPECT_EQ(EditDistance("", ""), 0u);
    EXPECT_EQ(EditDistance("size", "size"), 0u);
    EXPECT_EQ(EditDistance("siez", "size"), 1u) << "two letters that changed places";
    EXPECT_EQ(EditDistance("sze", "size"), 1u);
    EXPECT_EQ(EditDistance("sizee", "size"), 1u);
    EXPECT_EQ(EditDistance("sixe", "size"), 1u);
    EXPECT_EQ(EditDistance("", "size"), 4u);
    EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
    EXPECT_EQ(EditDistance("sitting", "kitten"), 3u);
}

TEST(Suggestion, IsTheNearestThatIsNear) {
    const std::vector<std::string> words{"--sampler", "--sample-offset", "--spp", "--nee", "-o"};
    EXPECT_EQ(Suggestion("--smapler", words), "--sampler");
    EXPECT_EQ(Suggestion("-spp", words), "--spp");
    EXPECT_EQ(Suggestion("--sampleoffset", words), "--sample-offset");
    EXPECT_EQ(Suggestion("--smaplre", words), "--sampler") << "two of seven letters";
    EXPECT_EQ(Suggestion("--sampling", words), std::nullopt) << "three of them";
    EXPECT_EQ(Suggestion("--exposure", words), std::nullopt);
    EXPECT_EQ(Suggestion("-x", words), std::nullopt) << "all of -o would be wrong";
    EXPECT_EQ(Suggestion("--", words), std::nullopt);
    EXPECT_EQ(Suggestion(std::string(1 << 20, 'x'), words), std::nullopt);
}

void ExpectMessage(const std::string& line, const std::string& message) {
    const std::vector<std::string> words = test::Words("raygraph " + line);
    std::vector<const char*> pointers;
    for (const std::string& word : words) pointers.push_back(word.c_str());
    const Error error =
        testing::ErrorOf([&] { ParseArguments(static_cast<int>(pointers.size()), pointers.data()); });
    EXPECT_EQ(error.Kind(), ErrorKind::Usage) << line;
    EXPECT_EQ(std::string(error.what()), message);
}

TEST(Suggestion, StandsInTheMessage) {
    ExpectMessage("rendr a.gltf",
                  "there is no command \"rendr\"; did you mean render? (see raygraph --help)");
    ExpectMessage("paint a.gltf", "there is no command \"paint\" (see raygraph --help)");
    ExpectMessage("render a.gltf --siez 64x64",
                  "render has no option --siez; did you mean --size? (see raygraph render --help)");
    ExpectMessage("render --siez=64x64 a.gltf",
                  "render has no option --siez; did you mean --size? (see raygraph render --help)");
    ExpectMessage("render --hlep",
                  "render has no option --hlep; did you mean --help? (see raygraph render --help)");
    ExpectMessage("info --device",
                  "info has no option --device; did you mean --devices? (see raygraph info --help)");
    ExpectMessage("bench a.gltf --outputs x", "bench has no option --outputs (see raygraph bench --help)");
    ExpectMessage("--verson", "there is no option --verson; did you mean --version? (see raygraph --help)");
    ExpectMessage("render a.gltf b.gltf",
                  "The following argument was not expected: b.gltf (see raygraph render --help)");
    ExpectMessage("render a.gltf '--x\ny'", "render has no option --x?y (see raygraph render --help)");
}

TEST(OptionText, SaysWhichFilesAnOptionTakes) {
    using Endings = std::vector<std::string>;
    EXPECT_EQ((OptionText{.operand = "FILE.exr", .help = "of .png"}.Extensions()), Endings{".exr"});
    EXPECT_EQ((OptionText{.operand = "FILE", .help = "Environment map, .hdr or .exr"}.Extensions()),
              (Endings{".hdr", ".exr"}));
    EXPECT_EQ((OptionText{.operand = "FILE", .help = "A script; see docs/editor.md"}.Extensions()),
              Endings{});
    EXPECT_EQ((OptionText{.operand = "LIST", .help = "Channels of an .exr"}.Extensions()), Endings{});
    EXPECT_FALSE((OptionText{.operand = "LIST"}.TakesFile()));
    EXPECT_TRUE((OptionText{.operand = "FOLDER"}.TakesFolder()));
}

TEST(OptionText, IsBriefWithItsFirstClause) {
    EXPECT_EQ((OptionText{.help = "Samples a pixel (64); with more"}.Brief()), "Samples a pixel (64)");
    EXPECT_EQ((OptionText{.help = "Bias: end paths"}.Brief()), "Bias: end paths");
    EXPECT_EQ((OptionText{.help = "Random numbers: a or b", .choices = {"a", "b"}}.Brief()),
              "Random numbers");
    const std::string longHelp =
        "A help that goes on and on without any end of a clause, as no help should ever do, but some may";
    const std::string brief = OptionText{.help = longHelp}.Brief();
    EXPECT_LE(brief.size(), 76u);
    EXPECT_TRUE(brief.ends_with("...")) << brief;
}

}  // namespace
}  // namespace raygraph::cli::suggestion_test
