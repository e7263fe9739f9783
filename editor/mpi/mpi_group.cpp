#include "editor/mpi/mpi_group.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/check.h"
#include "base/stopwatch.h"
#include "base/text.h"

namespace raygraph::mpi {

namespace {

using session::SampleRange;

enum Tag : int { kTagRequest = 1, kTagAnswer = 2 };

// A process sends this to the root for one of its devices.
struct Request {
    uint32_t device;
    uint32_t isStopRequested;
    double samplesPerSecond;
};
struct Answer {
    uint32_t device;
    uint32_t first, count;  // count 0: nothing is left
};

// Paces polling for messages: at first without pause, then at growing intervals.
class Patience {
  public:
    void Reset() { m_pause = kShortest; }
    std::chrono::microseconds Next() {
        const auto pause = m_pause;
        m_pause = std::min(kLongest, m_pause * 2);
        return pause;
    }

  private:
    static constexpr std::chrono::microseconds kShortest{100}, kLongest{10'000};
    std::chrono::microseconds m_pause = kShortest;
};

// Is the interval between calls of the tick.
constexpr double kTickSeconds = 0.05;

void Require(int result, const char* what) {
    if (result == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING] = {};
    int length = 0;
    MPI_Error_string(result, text, &length);
    throw MakeError(ErrorKind::Io, "{}: {}", what, text);
}

// Adds records of sums as passes::PackSums makes them, for MPI_Reduce. One element of our datatype is one
// record, which is longer with the squares.
template <bool withSquares>
void AddRecords(void* from, void* into, int* count, MPI_Datatype*) {
    const size_t words = passes::WordsOfRecord(withSquares) * static_cast<size_t>(*count);
    passes::AddRecords({static_cast<uint32_t*>(into), words}, {static_cast<const uint32_t*>(from), words},
                       withSquares);
}

// Frees the MPI datatype and operation.
struct Reduction {
    explicit Reduction(bool withSquares) {
        Require(MPI_Op_create(withSquares ? AddRecords<true> : AddRecords<false>, 1, &op), "MPI_Op_create");
        Require(
            MPI_Type_contiguous(static_cast<int>(passes::WordsOfRecord(withSquares)), MPI_UINT32_T, &record),
            "MPI_Type_contiguous");
        Require(MPI_Type_commit(&record), "MPI_Type_commit");
    }
    ~Reduction() {
        MPI_Type_free(&record);
        MPI_Op_free(&op);
    }
    Reduction(const Reduction&) = delete;
    Reduction& operator=(const Reduction&) = delete;

    MPI_Op op = MPI_OP_NULL;
    MPI_Datatype record = MPI_DATATYPE_NULL;
};

}  // namespace

MpiGroup::MpiGroup() {
    Require(MPI_Comm_dup(MPI_COMM_WORLD, &m_world), "MPI_Comm_dup");
    Require(MPI_Comm_set_errhandler(m_world, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
    const auto rankAndSize = [](MPI_Comm of, uint32_t& rank, uint32_t& size) {
        int index = 0, count = 1;
        Require(MPI_Comm_rank(of, &index), "MPI_Comm_rank");
        Require(MPI_Comm_size(of, &count), "MPI_Comm_size");
        rank = static_cast<uint32_t>(index);
        size = static_cast<uint32_t>(count);
    };
    rankAndSize(m_world, m_rank, m_size);
    MPI_Comm local = MPI_COMM_NULL;
    Require(MPI_Comm_split_type(m_world, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &local),
            "MPI_Comm_split_type");
    rankAndSize(local, m_localRank, m_localSize);
    MPI_Comm_free(&local);
}

MpiGroup::~MpiGroup() {
    MPI_Comm_free(&m_world);
}

void MpiGroup::WaitForAll() {
    MPI_Request request = MPI_REQUEST_NULL;
    Require(MPI_Ibarrier(m_world, &request), "MPI_Ibarrier");
    Patience patience;
    for (int isDone = 0; isDone == 0;) {
        Require(MPI_Test(&request, &isDone, MPI_STATUS_IGNORE), "MPI_Test");
        if (isDone == 0) std::this_thread::sleep_for(patience.Next());
    }
}

void MpiGroup::Broadcast(std::span<std::byte> bytes) {
    WaitForAll();
    RG_CHECK(bytes.size() <= 0x7FFFFFFFu);
    Require(MPI_Bcast(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, 0, m_world), "MPI_Bcast");
}

uint64_t MpiGroup::Reduced(uint64_t value, MPI_Op op) {
    WaitForAll();
    uint64_t reduced = 0;
    Require(MPI_Allreduce(&value, &reduced, 1, MPI_UINT64_T, op, m_world), "MPI_Allreduce");
    return reduced;
}

uint64_t MpiGroup::Sum(uint64_t value) {
    return Reduced(value, MPI_SUM);
}

uint64_t MpiGroup::Minimum(uint64_t value) {
    return Reduced(value, MPI_MIN);
}

void MpiGroup::AddAtRoot(passes::ExactSums& sums) {
    constexpr size_t kPixels = size_t{1} << 18;  // per reduction: 32 MiB with squares
    const Reduction reduction(sums.HasSquares());
    std::vector<uint32_t> records, total;
    WaitForAll();
    for (size_t first = 0; first < sums.PixelCount(); first += kPixels) {
        const size_t count = std::min(kPixels, sums.PixelCount() - first);
        records.resize(count * passes::WordsOfRecord(sums.HasSquares()));
        passes::PackSums(sums, first, records);
        if (m_rank == 0) total.resize(records.size());
        Require(MPI_Reduce(records.data(), total.data(), static_cast<int>(count), reduction.record,
                           reduction.op, 0, m_world),
                "MPI_Reduce");
        if (m_rank == 0) passes::UnpackSums(total, first, sums);
    }
}

void MpiGroup::Deal(session::BlockDealer* dealer, session::BlockQueue& queue, const Tick& tick) {
    if (dealer != nullptr)
        DealAsRoot(*dealer, queue, tick);
    else
        RequestFromRoot(queue, tick);
}

void MpiGroup::DealAsRoot(session::BlockDealer& dealer, session::BlockQueue& queue, const Tick& tick) {
    uint64_t othersLeft = Sum(0);  // devices of other processes that have not been told that nothing is left
    Patience patience;
    Stopwatch sinceTick;
    bool isStopRequested = false;
    while (othersLeft > 0 || !queue.IsOver()) {
        if (queue.HasFailed()) {
            queue.Close();
            queue.RethrowError();
        }
        int hasMessage = 0;
        MPI_Status status{};
        Require(MPI_Iprobe(MPI_ANY_SOURCE, kTagRequest, m_world, &hasMessage, &status), "MPI_Iprobe");
        if (hasMessage != 0) {
            Request request{};
            Require(MPI_Recv(&request, sizeof(request), MPI_BYTE, status.MPI_SOURCE, kTagRequest, m_world,
                             MPI_STATUS_IGNORE),
                    "MPI_Recv");
            isStopRequested |= request.isStopRequested != 0;
            if (isStopRequested) dealer.Stop();
            const auto block = dealer.Next({static_cast<uint32_t>(status.MPI_SOURCE), request.device},
                                           request.samplesPerSecond);
            const Answer answer{request.device, block ? block->first : 0, block ? block->count : 0};
            Require(MPI_Send(&answer, sizeof(answer), MPI_BYTE, status.MPI_SOURCE, kTagAnswer, m_world),
                    "MPI_Send");
            if (!block) --othersLeft;
            patience.Reset();
        }
        const auto wait = hasMessage != 0 ? std::chrono::microseconds(0) : patience.Next();
        if (queue.IsOver()) {
            std::this_thread::sleep_for(wait);
        } else if (const auto request = queue.TakeRequest(wait)) {
            queue.Answer(request->device, dealer.Next({0, request->device}, request->samplesPerSecond));
            patience.Reset();
        }
        if (sinceTick.Seconds() < kTickSeconds) continue;
        tick(isStopRequested);
        sinceTick = {};
    }
    tick(isStopRequested);
}

void MpiGroup::RequestFromRoot(session::BlockQueue& queue, const Tick& tick) {
    Sum(queue.DeviceCount());
    Patience patience;
    Stopwatch sinceTick;
    bool isStopRequested = false;
    while (!queue.IsOver()) {
        if (queue.HasFailed()) {
            queue.Close();
            queue.RethrowError();
        }
        int hasMessage = 0;
        Require(MPI_Iprobe(0, kTagAnswer, m_world, &hasMessage, MPI_STATUS_IGNORE), "MPI_Iprobe");
        if (hasMessage != 0) {
            Answer answer{};
            Require(MPI_Recv(&answer, sizeof(answer), MPI_BYTE, 0, kTagAnswer, m_world, MPI_STATUS_IGNORE),
                    "MPI_Recv");
            queue.Answer(answer.device, answer.count > 0
                                            ? std::optional(SampleRange{answer.first, answer.count})
                                            : std::nullopt);
            patience.Reset();
        }
        const auto wait = hasMessage != 0 ? std::chrono::microseconds(0) : patience.Next();
        if (const auto requested = queue.TakeRequest(wait)) {
            const Request request{requested->device, isStopRequested ? 1u : 0u, requested->samplesPerSecond};
            Require(MPI_Send(&request, sizeof(request), MPI_BYTE, 0, kTagRequest, m_world), "MPI_Send");
            patience.Reset();
        }
        if (sinceTick.Seconds() < kTickSeconds) continue;
        isStopRequested |= tick(false);
        sinceTick = {};
    }
}

}  // namespace raygraph::mpi
