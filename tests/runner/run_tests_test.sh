#!/usr/bin/env bash
# run_tests_test.sh RUN_TESTS: what run_tests says of a program whose tests pass, fail, crash, hang and skip.
set -u
runner=$1
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT

# Speaks as GoogleTest does. A process lives for all the tests that it is given, unless one of them ends it.
cat >"$folder/program" <<'END'
#!/usr/bin/env bash
all=(A.Passes A.Fails A.Crashes A.Hangs A.SkipsAsExpected A.Skips A.PassesToo B.Passes B.PassesToo)
for word in "$@"; do
    case $word in
        --gtest_list_tests) for suite in A B; do
            printf '%s.\n' $suite
            for name in "${all[@]}"; do [[ $name != $suite.* ]] || printf '  %s\n' "${name#*.}"; done
        done && exit 0 ;;
        --gtest_flagfile=*) filter=$(cat "${word#*=}") ;;
    esac
done
filter=:${filter#*=}:
echo process >>"${0%/*}/processes"
for name in "${all[@]}"; do
    [[ $filter == *":$name:"* ]] || continue
    echo "[ RUN      ] $name"
    case $name in
        ?.Passes*) printf 'a line without an end[       OK ] %s (12 ms)\n' "$name" ;;
        A.Fails) echo "what was wrong"; echo "[  FAILED  ] $name, where GetParam() = 3 (1 ms)"; status=1 ;;
        A.Crashes) kill -SEGV $$ ;;
        A.Hangs) sleep 100 ;;
        A.Skips*) echo "because of ${name#A.Skips}"; echo "[  SKIPPED ] $name (0 ms)" ;;
    esac
done
exit "${status:-0}"
END
chmod +x "$folder/program"
echo 'because of AsExpected | a reason' >"$folder/skips"
bad=0
Expect() { # TEXT WHAT
    [[ $text == *"$1"* ]] || { echo "$2: '$1' is not in:"; echo "$text"; bad=1; }
}

text=$("$runner" --timeout 2 --group 99 --skips "$folder/skips" --out "$folder/out" "$folder/program" 2>&1)
[[ $? == 1 ]] || { echo "the exit status is not 1"; bad=1; }
Expect '9 tests: 4 passed, 4 failed, 1 skipped as expected' 'the tests behind a crash and a hang are run'
Expect 'failed: A.Fails' 'a failure has its name'
Expect 'what was wrong' 'a failure has its message'
Expect "alone: $folder/program --gtest_filter=A.Fails" 'a failure says how to run it alone'
Expect 'crashed: A.Crashes' 'a crash is that of its test'
Expect 'timed-out: A.Hangs' 'a test that hangs is named'
Expect 'skipped-unexpectedly: A.Skips ' 'a skip that is not in the list fails'
[[ $(wc -l <"$folder/processes") == 3 ]] || { echo "three processes, one for each that ended early and one: $(cat "$folder/processes")"; bad=1; }
[[ $(wc -l <"$folder/out/results.txt") == 9 ]] || { echo "not a line a test in results.txt"; bad=1; }

# These end outside of any test: a program before its first test, one after its last test although a test had failed,
# the shell that keeps the results, and a program that does not even list its tests.
Program() { # NAME LINES...: writes a program with the tests C.Fails and C.Passes
    printf '#!/usr/bin/env bash\n[[ $1 != *list_tests ]] || { printf "C.\\n  Fails\\n  Passes\\n"; exit 0; }\n' >"$folder/$1"
    printf '%s\n' "${@:2}" >>"$folder/$1"
    chmod +x "$folder/$1"
}
fails='echo "[ RUN      ] C.Fails"; echo "[  FAILED  ] C.Fails (1 ms)"'
passes='echo "[ RUN      ] C.Passes"; echo "[       OK ] C.Passes (1 ms)"'
Program before 'exit 0'
Program behind "$fails" "$passes" 'kill -SEGV $$'
Program killer "$passes" 'kill -KILL $PPID'
for name in before behind killer; do
    text=$("$runner" --skips "$folder/skips" "$folder/$name" 2>&1)
    [[ $? == 1 ]] || { echo "the exit status of '$name' is not 1"; bad=1; }
    [[ $name == behind ]] || Expect 'not-run: C.Fails' "what '$name' has not run is a failure"
    [[ $name == killer ]] || Expect "$name.BeforeOrAfterTheTests" "what ended '$name' is named"
done
printf '#!/usr/bin/env bash\nexit 127\n' >"$folder/mute" && chmod +x "$folder/mute"
text=$("$runner" --skips "$folder/skips" "$folder/program" "$folder/mute" 2>&1)
[[ $? == 2 ]] || { echo "the exit status of a program that lists no tests is not 2"; bad=1; }
Expect 'mute does not list its tests: status 127' 'a program that does not start is named'
text=$("$runner" --filter 'No.Such' --skips "$folder/skips" "$folder/mute" 2>&1) && { echo "a filter without a test passes"; bad=1; }

text=$("$runner" --shard 1/2 --skips "$folder/skips" "$folder/program" 2>&1) || { echo "shard 1 of 2 fails"; bad=1; }
Expect '2 tests: 2 passed, 0 failed' 'a shard is its own suites alone'
echo 'A.PassesToo | measures time' >"$folder/alone"
text=$("$runner" --part alone --alone "$folder/alone" --skips "$folder/skips" "$folder/program" 2>&1)
Expect '1 tests: 1 passed, 0 failed' 'of the tests that run alone, there is one'
text=$("$runner" --timeout 1 --part together --alone "$folder/alone" --skips "$folder/skips" "$folder/program" 2>&1)
Expect '8 tests: 3 passed, 4 failed' 'the others are run without it'
exit $bad
