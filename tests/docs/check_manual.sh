#!/usr/bin/env bash
# The program is installed with a manual page for itself and for each command, of that name, which has its options and which
# groff formats without warnings. Usage: check_manual.sh PROGRAM BUILD_FOLDER
set -euo pipefail
program=$1 build=$2
prefix=$(mktemp -d)
trap 'rm -rf -- "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix" --component raygraph_program >/dev/null
pages=$prefix/share/man/man1

Fail() {
    printf '%s\n' "$*"
    exit 1
}

Commands() { # COMMAND...
    "$program" "$@" --help | sed -n '/^Commands:$/,/^$/s/^  \([a-z]*\) .*/\1/p'
}

commands=('')
for command in $(Commands); do
    commands+=("$command")
    for within in $(Commands "$command"); do commands+=("$command $within"); done
done
count=0
for command in "${commands[@]}"; do
    name=raygraph${command:+-${command/ /-}}
    [[ -s $pages/$name.1.gz ]] || Fail "there is no $name.1.gz"
    text=$(gunzip -c -- "$pages/$name.1.gz" | groff -man -ww -K utf8 -T utf8 -P -c 2>"$prefix/warnings" | sed $'s/.\b//g' | tr -s ' ')
    [[ ! -s $prefix/warnings ]] || Fail "$name.1: $(<"$prefix/warnings")"
    [[ $text == *NAME*" $name - "* ]] || Fail "$name.1 has another name"
    # shellcheck disable=SC2086
    for option in $("$program" $command --help-all | grep -oE -- '^  (-[a-z],)?--[a-z-]+' | sed 's/.*--/--/'); do
        [[ $text == *"$option"* ]] || Fail "$name.1 lacks $option"
    done
    count=$((count + 1))
done
((count > 2)) || Fail "the help lists no commands"
[[ $(ls -- "$pages" | wc -l) == "$count" ]] || Fail "there are other pages: $(ls -- "$pages")"
echo "$count pages"
