#!/bin/sh
# man_pages.sh PROGRAM HELP2MAN FOLDER: replaces the folder by raygraph.1.gz and a page for each command that the program's
# help lists, and for those that a command's help lists: raygraph-graph-run.1.gz.
set -eu
program=$1 help2man=$2 folder=$3
version=$("$program" --version)

Page() { # NAME DESCRIPTION HELP_OPTION
    "$help2man" --no-info --name "$2" --help-option "$3" --version-string "$1 (Raygraph) ${version#* }" \
        --output "$folder/$1.1" "$program"
}

rm -rf -- "$folder"
mkdir -p -- "$folder"
Page raygraph "path-trace glTF scenes on Vulkan devices" --help-all
Commands() { # COMMAND...
    "$program" "$@" --help | sed -n '/^Commands:$/,/^$/s/^  \([a-z]*\)  */\1 /p'
}

Commands | while read -r command description; do
    Page "raygraph-$command" "$description" "$command --help-all"
    Commands "$command" | while read -r within description; do
        Page "raygraph-$command-$within" "$description" "$command $within --help-all"
    done
done
gzip -9n -- "$folder"/*
