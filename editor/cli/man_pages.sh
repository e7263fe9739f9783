#!/bin/sh
# man_pages.sh PROGRAM HELP2MAN FOLDER: replaces the folder by raygraph.1.gz and a page for each command that the program's
# help lists.
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
"$program" --help | sed -n '/^Commands:$/,/^$/s/^  \([a-z]*\)  */\1 /p' | while read -r command description; do
    Page "raygraph-$command" "$description" "$command --help-all"
done
gzip -9n -- "$folder"/*
