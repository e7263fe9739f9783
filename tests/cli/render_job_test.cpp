// Tests what the first process of a render sends to the others.
#include "editor/cli/rendering.h"

#include "tests/cli/cli_test.h"

namespace raygraph::cli::render_job_test {
namespace {

TEST(RenderJob, TextSaysAllOfIt) {
    RenderJob job;
    job.settings.size = {20, 14};
    job.settings.paths.seed = 5;
    job.settings.camera = "a \"front\" camera";
    job.settings.lightGroups = {{"lamps", {"l\xE4mp*"}}};  // not UTF-8: a pattern may have any bytes
    job.aovs = {Aov::Albedo, Aov::Depth};
    job.firstSample = 7;
    job.samplesWanted = 100;
    RenderJob told = JobFrom(JobText(job));
    EXPECT_EQ(Texts(told.settings), Texts(job.settings));
    EXPECT_EQ(told.aovs, job.aovs);
    EXPECT_EQ(told.firstSample, 7u);
    EXPECT_EQ(told.samplesWanted, 100u);
    job.samplesWanted.reset();
    told = JobFrom(JobText(job));
    EXPECT_FALSE(told.samplesWanted) << "until the time is up";
}

TEST(RenderJob, ATextThatIsNoneIsBadInput) {
    for (const char* text : {"", "{}", "[1]", "job"})
        test::ExpectError(
            ErrorKind::BadInput, [&] { JobFrom(text); }, "the render that is asked for cannot be read");
}

}  // namespace
}  // namespace raygraph::cli::render_job_test
