// raygraph-mpi: `raygraph render` by the ranks of an MPI job. See docs/cluster.md.
#include <mpi.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include "base/os.h"
#include "editor/cli/commands.h"
#include "editor/cli/run_command.h"
#include "editor/mpi/mpi_group.h"

namespace raygraph::mpi {

namespace {

using namespace cli;  // NOLINT: the program is one of its commands

// If several ranks fail for one reason, the root reports it: it ends the job while the others wait this long.
constexpr auto kRootGoesFirst = std::chrono::seconds(2);

// Silences all ranks but the root, except for the error with which one ends.
RenderArguments ArgumentsOf(const MpiGroup& group, RenderArguments arguments) {
    if (group.IsRoot()) return arguments;
    arguments.isQuiet = true;
    arguments.verbosity = 0;
    arguments.logFile.clear();
    return arguments;
}

ExitCode Render(MpiGroup& group, const RenderArguments& arguments) {
    return RunCommand(ArgumentsOf(group, arguments), [&](const RenderArguments& parsed, Console& console) {
        try {
            return RenderCommand(parsed, console, &group);
        } catch (...) {
            if (!group.IsRoot()) std::this_thread::sleep_for(kRootGoesFirst);
            throw;
        }
    });
}

ExitCode Run(MpiGroup& group, int argc, const char* const* argv) {
    const Arguments arguments = ParseArguments(argc, argv);
    if (const auto* text = std::get_if<ShowText>(&arguments)) {
        if (group.IsRoot()) std::fputs(text->text.c_str(), stdout);
        RequirePrinted();
        return ExitCode::Done;
    }
    const auto* render = std::get_if<RenderArguments>(&arguments);
    if (render == nullptr)
        throw Error(ErrorKind::Usage, "raygraph-mpi renders; the other commands are raygraph's");
    // The root has the lowest index, so it notices if the other ranks have higher ones
    if (render->shard && group.Sum(render->shard->index) != uint64_t{group.Size()} * render->shard->index)
        throw Error(ErrorKind::Usage,
                    "--shard auto is another part for each rank, and all ranks render one part; give I/N");
    const ExitCode code = Render(group, *render);
    // A process that ends early may end the job while the root is writing
    if (code == ExitCode::Done || code == ExitCode::TryAgain) group.Sum(0);
    return code;
}

// A rank that fails ends the job, since others may be waiting for it.
int Main(int argc, char** argv) {
    int provided = MPI_THREAD_SINGLE;
    if (MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS) return 1;
    ExitCode code = ExitCode::Failure;
    {
        std::optional<MpiGroup> group;
        code = Guarded(
            [&](const char* text) {
                if (!group || group->IsRoot()) std::fprintf(stderr, "raygraph-mpi: %s\n", text);
            },
            [&] {
                if (provided < MPI_THREAD_FUNNELED)
                    throw Error(ErrorKind::Io, "this MPI lets no other threads run beside it");
                group.emplace();
                return Run(*group, argc, argv);
            });
        if (code != ExitCode::Done && code != ExitCode::TryAgain) {
            std::fflush(nullptr);
            if (group && !group->IsRoot()) std::this_thread::sleep_for(kRootGoesFirst);
            MPI_Abort(MPI_COMM_WORLD, static_cast<int>(code));
        }
    }
    MPI_Finalize();
    return static_cast<int>(code);
}

}  // namespace

}  // namespace raygraph::mpi

int main(int argc, char** argv) {
    raygraph::os::IgnoreWriteSignals();
    return raygraph::mpi::Main(argc, argv);
}
