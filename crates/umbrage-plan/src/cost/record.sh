#!/bin/sh
# Prints rows for recorded.csv: of some work.csv of one machine, each row with the least of its times.
#
# cargo xtask compare nave nave-soft street street-soft ... --out target/times-1      (full-size scenes, nothing beside; 2 and 3 likewise)
# sh crates/umbrage-plan/src/cost/record.sh content target/times-*/work.csv >> crates/umbrage-plan/src/cost/recorded.csv
#
# The first argument is the section: `content` for full-size scenes, `check` for small scenes. All rows of full-size scenes are
# kept, and whichever of the others one appends. `cargo test -p umbrage-plan recorded` then tells the prices that fit.
set -eu
if [ $# -lt 2 ]; then
    echo "usage: record.sh content|check WORK.CSV..." >&2
    exit 2
fi
section=$1
shift
awk -F, -v section="$section" '
    FNR == 1 { next }
    {
        work = $1
        for (i = 2; i <= NF - 2; i++) work = work "," $i
        draw = $(NF - 1)
        lookup = $NF
        if (!(work in least_draw)) order[++count] = work
        if (!(work in least_draw) || draw + 0 < least_draw[work] + 0) least_draw[work] = draw
        if (!(work in least_lookup) || lookup + 0 < least_lookup[work] + 0) least_lookup[work] = lookup
    }
    END {
        for (i = 1; i <= count; i++)
            print section "," order[i] "," least_draw[order[i]] "," least_lookup[order[i]]
    }
' "$@"
