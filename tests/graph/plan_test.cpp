// The plan of hand-made frames, as text: order, culling, barriers, lifetimes.
#include <nlohmann/json.hpp>

#include "tests/graph/graph_maker.h"

namespace raygraph::plan_test {
namespace {

TEST(Plan, ThreePassFrame_ReadsAsWritten) {
    GraphMaker graph;
    const TlasId tlas = graph.Imported<ResourceKind::Tlas>("sceneTlas");
    const TextureId accumulated = graph.Persistent("accumulated");
    TextureId radiance = graph.Texture("radiance", 2);
    graph.AddPass("Trace", PassKind::RayTracing);
    graph.Use(tlas, Access::TraceStructure);
    radiance = graph.Use(radiance, Access::StorageWrite);
    graph.AddPass("Accumulate", PassKind::Compute);
    graph.Use(radiance, Access::StorageRead);
    const TextureId mean = graph.Use(accumulated, Access::StorageUpdate);
    TextureId shown = graph.Texture("display", 1);
    graph.AddPass("Tonemap", PassKind::Compute);
    graph.Use(mean, Access::StorageRead);
    shown = graph.Use(shown, Access::StorageWrite);
    graph.Present(shown);

    EXPECT_EQ(graph.Text(), R"(3 passes, 6 barriers, 2 MiB of transient memory (1 MiB saved by sharing)

1 Trace (ray tracing)
    reads   sceneTlas v0 (traced)
    writes  radiance v1 (storage write)
    waits   radiance: first use -> RayTracingShader write, Undefined -> General

2 Accumulate (compute)
    reads   radiance v1 (storage read)
    updates accumulated v1 (storage update)
    waits   radiance: RayTracingShader write -> ComputeShader read, General
    waits   accumulated: first use -> ComputeShader read+write, Undefined -> General

3 Tonemap (compute)
    reads   accumulated v1 (storage read)
    writes  display v1 (storage write)
    waits   accumulated: ComputeShader write -> ComputeShader read, General
    waits   display: memory of radiance, ComputeShader done -> ComputeShader write, Undefined -> General

end
    shows   display v1
    waits   display: ComputeShader write -> FragmentShader read, General -> ShaderReadOnly

resources
    sceneTlas    TLAS                        imported    pass 1
    accumulated  texture 64x64 rgba32f       persistent  passes 2-3
    radiance     texture 64x64 rgba32f       transient   passes 1-2
    display      texture 64x64 rgba32f       transient   passes 3-end

memory
    block 0, 2 MiB: radiance, then display
)");
}

TEST(Plan, EmptyFrame_HasNoPassAndNoBarrier) {
    const GraphMaker graph;
    EXPECT_EQ(graph.Text(), "0 passes, 0 barriers\n");
}

TEST(Plan, Order_IsThatOfDeclaration) {
    GraphMaker graph;
    const TextureId a = graph.Pass("A", {}, graph.Texture("a"));
    const TextureId b = graph.Pass("B", {}, graph.Texture("b"));
    graph.Present(graph.Pass("C", {b, a}, graph.Texture("c")));
    EXPECT_EQ(graph.Order(), "A B C");
}

TEST(Culling, PassThatLeadsNowhere_IsCulledWithItsInputs) {
    GraphMaker graph;
    const TextureId color = graph.Pass("RasterView", {}, graph.Texture("color"));
    [[maybe_unused]] const TextureId sharp = graph.Pass("Sharpen", {color}, graph.Texture("sharp"));
    graph.Present(graph.Pass("Trace", {}, graph.Texture("radiance")));
    const std::string text = graph.Text();
    EXPECT_EQ(graph.Order(), "Trace");
    EXPECT_NE(text.find("culled\n"
                        "    RasterView (compute): only culled Sharpen needs it\n"
                        "    Sharpen (compute): nothing needs sharp\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("color     texture 64x64 rgba32f       transient   unused\n"), std::string::npos)
        << text;
}

TEST(Culling, PassWithoutWrites_IsCulledUnlessKeptAlive) {
    GraphMaker graph;
    graph.AddPass("Count", PassKind::Compute);
    EXPECT_EQ(graph.Order(), "");
    EXPECT_NE(graph.Text().find("Count (compute): it writes nothing"), std::string::npos);
    graph.passes[0].keepAlive = true;
    EXPECT_EQ(graph.Order(), "Count");
}

TEST(Culling, KeepAlivePass_KeepsWhatItReads) {
    GraphMaker graph;
    const TextureId a = graph.Pass("Make", {}, graph.Texture("a"));
    graph.AddPass("Look", PassKind::Compute);
    graph.Use(a, Access::StorageRead);
    graph.passes[1].keepAlive = true;
    EXPECT_EQ(graph.Order(), "Make Look");
}

TEST(Culling, OverwrittenContents_DoNotKeepTheirPass) {
    GraphMaker graph;
    TextureId a = graph.Pass("First", {}, graph.Texture("a"));
    a = graph.Pass("Second", {}, a);
    graph.Present(a);
    EXPECT_EQ(graph.Order(), "Second");
}

TEST(Culling, UpdatedContents_KeepTheirPass) {
    GraphMaker graph;
    TextureId a = graph.Pass("First", {}, graph.Texture("a"));
    graph.AddPass("Second", PassKind::Compute);
    a = graph.Use(a, Access::StorageUpdate);
    graph.Present(a);
    EXPECT_EQ(graph.Order(), "First Second");
}

TEST(Culling, CopiesIntoPartsOfABuffer_AreAllKept) {
    GraphMaker graph;
    BufferId records = graph.Buffer("records");
    graph.AddPass("Upload head", PassKind::Transfer);
    records = graph.Use(records, Access::CopyWrite);
    graph.AddPass("Upload tail", PassKind::Transfer);
    records = graph.Use(records, Access::CopyWrite);
    graph.ReadOnHost(records);
    EXPECT_EQ(graph.Order(), "Upload head Upload tail");
}

TEST(Culling, ToggledView_StopsItsAccumulation) {
    const auto order = [](bool isPathTraced) {
        GraphMaker graph;
        const TextureId radiance = graph.Pass("Trace", {}, graph.Texture("radiance"));
        graph.AddPass("Accumulate", PassKind::Compute);
        graph.Use(radiance, Access::StorageRead);
        const TextureId mean = graph.Use(graph.Persistent("mean"), Access::StorageUpdate);
        const TextureId raster = graph.Pass("Raster", {}, graph.Texture("raster"));
        graph.Present(isPathTraced ? mean : raster);
        return graph.Order();
    };
    EXPECT_EQ(order(true), "Trace Accumulate");
    EXPECT_EQ(order(false), "Raster");
}

TEST(Culling, HistoryWrittenForTheNextFrame_IsKeptWhileItIsRead) {
    const auto order = [](bool isShown) {
        GraphMaker graph;
        const TextureId history = graph.Persistent("history");
        const TextureId blended = graph.Pass("Blend", {history}, graph.Texture("blended"));
        [[maybe_unused]] const TextureId next = graph.Pass("Keep history", {blended}, history);
        const TextureId other = graph.Pass("Other", {}, graph.Texture("other"));
        graph.Present(isShown ? blended : other);
        return graph.Order();
    };
    EXPECT_EQ(order(true), "Blend Keep history");
    EXPECT_EQ(order(false), "Other");
}

TEST(Culling, AlwaysPersistentResource_KeepsItsWriter) {
    GraphMaker graph;
    [[maybe_unused]] const TextureId map =
        graph.Pass("Light map", {}, graph.Persistent("lightMap", {}, Persistence::Always));
    EXPECT_EQ(graph.Order(), "Light map");
}

TEST(Culling, ExportedAndHostReadResources_KeepTheirWriters) {
    GraphMaker graph;
    const TextureId host = graph.Imported<ResourceKind::Texture>("host");
    graph.Export(graph.Pass("Fill", {}, host), VK_IMAGE_LAYOUT_GENERAL);
    BufferId histogram = graph.Buffer("histogram");
    graph.AddPass("Count", PassKind::Compute);
    histogram = graph.Use(histogram, Access::StorageWrite);
    graph.ReadOnHost(histogram);
    EXPECT_EQ(graph.Order(), "Fill Count");
    EXPECT_NE(graph.Text().find("waits   histogram: ComputeShader write -> Host read\n"), std::string::npos);
}

TEST(Plan, CulledPass_LeavesNoBarrierBehind) {
    GraphMaker graph;
    const TextureId shared = graph.Pass("Make", {}, graph.Texture("shared"));
    [[maybe_unused]] const TextureId unused =
        graph.Pass("Unused", {shared}, graph.Texture("unused"), PassKind::RayTracing);
    graph.Present(graph.Pass("Use", {shared}, graph.Texture("used")));
    EXPECT_EQ(graph.Text().find("RayTracingShader"), std::string::npos) << graph.Text();
}

TEST(PlanDot, ShowsPassesVersionsAndRoots) {
    GraphMaker graph;
    const TextureId a = graph.Pass("Make", {}, graph.Texture("a"));
    [[maybe_unused]] const TextureId b = graph.Pass("Un\"used", {a}, graph.Texture("b"));
    graph.Present(a);
    EXPECT_EQ(DescribePlanDot(graph, Compile(graph)), R"(digraph frame {
    rankdir=LR;
    node [fontname="sans-serif"];
    p0 [shape=box, style=solid, label="1 Make\ncompute"];
    p1 [shape=box, style=dashed, label="culled Un\"used\ncompute"];
    r0v1 [shape=ellipse, style=solid, label="a v1"];
    p0 -> r0v1;
    r0v1 -> p1 [style=dashed];
    r1v1 [shape=ellipse, style=solid, label="b v1"];
    p1 -> r1v1 [style=dashed];
    root0 [shape=plaintext, label="shown"];
    r0v1 -> root0;
}
)");
}

TEST(PlanJson, HasWhatAScriptNeedsToDrawThePlan) {
    GraphMaker graph;
    const TextureId a = graph.Pass("Make", {}, graph.Texture("a", 2));
    [[maybe_unused]] const TextureId b =
        graph.Pass("Un\"used", {a}, graph.Texture("b"), PassKind::RayTracing);
    const TextureId c = graph.Pass("Use", {a}, graph.Texture("c", 2));
    const TextureId d = graph.Pass("Again", {c}, graph.Texture("d", 1));
    graph.Present(d);
    const nlohmann::json plan = nlohmann::json::parse(DescribePlanJson(graph, Compile(graph)));
    std::vector<std::string> order;
    for (const nlohmann::json& pass : plan.at("passes")) order.push_back(pass.at("name"));
    EXPECT_EQ(order, (std::vector<std::string>{"Make", "Use", "Again"}));
    const nlohmann::json& use = plan["passes"][1];
    EXPECT_EQ(use.at("kind"), "compute");
    EXPECT_EQ(
        use.at("reads"),
        nlohmann::json::parse(R"([{"resource": 0, "name": "a", "version": 1, "access": "storage read"}])"));
    EXPECT_EQ(
        use.at("writes"),
        nlohmann::json::parse(R"([{"resource": 2, "name": "c", "version": 1, "access": "storage write"}])"));
    EXPECT_EQ(use.at("barriers")[0], nlohmann::json::parse(R"({"resource": 0, "name": "a",
        "from": {"stages": ["ComputeShader"], "access": "write", "layout": "General"},
        "to": {"stages": ["ComputeShader"], "access": "read", "layout": "General"}})"));
    EXPECT_EQ(plan.at("culled")[0].at("name"), "Un\"used");
    EXPECT_EQ(plan["culled"][0].at("why"), "nothing needs b");
    EXPECT_EQ(plan.at("end").at("roots")[0],
              nlohmann::json::parse(R"({"resource": 3, "name": "d", "version": 1, "kind": "presented"})"));

    const nlohmann::json& resources = plan.at("resources");
    ASSERT_EQ(resources.size(), 4u);
    EXPECT_EQ(resources[1], nlohmann::json::parse(R"({"name": "b", "kind": "texture", "origin": "transient",
        "width": 64, "height": 64, "format": "rgba32f", "levels": 1, "layers": 1,
        "first_pass": null, "last_pass": null, "block": null})"));
    EXPECT_EQ(resources[2].at("first_pass"), 1);
    EXPECT_EQ(resources[2].at("last_pass"), 2);
    EXPECT_EQ(resources[3].at("last_pass"), 3) << "shown: until the end";
    // d takes over the memory of a
    EXPECT_EQ(plan.at("memory").at("bytes"), 4 << 20);
    EXPECT_EQ(plan["memory"].at("bytes_without_sharing"), 5 << 20);
    ASSERT_EQ(plan["memory"].at("blocks").size(), 2u);
    EXPECT_EQ(plan["memory"]["blocks"][resources[0].at("block").get<size_t>()],
              nlohmann::json::parse(R"({"bytes": 2097152, "resources": [0, 3]})"));
    EXPECT_EQ(plan["passes"][2]["barriers"][1].value("memory_of", -1), 0) << plan["passes"][2]["barriers"];
}

TEST(PlanJson, NamesThePartOfATexture) {
    GraphMaker graph;
    TextureId chain = graph.Chain("chain", 2);
    for (const uint32_t level : {0u, 1u}) {
        graph.AddPass("Fill", PassKind::Compute);
        chain = graph.Use(chain, Access::StorageWrite, Level(level));
    }
    graph.Present(chain);
    const nlohmann::json plan = nlohmann::json::parse(DescribePlanJson(graph, Compile(graph)));
    EXPECT_EQ(plan.at("passes")[1].at("writes")[0], nlohmann::json::parse(R"({"resource": 0, "name": "chain",
        "first_level": 1, "levels": 1, "first_layer": 0, "layers": 1,
        "version": 2, "access": "storage write"})"));
}

}  // namespace
}  // namespace raygraph::plan_test
