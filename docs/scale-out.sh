#!/bin/sh
# The comparison as a Slurm job array, a shard a task, and a job that joins the shards when all are done:
#
#   docs/scale-out.sh FOLDER SHARDS [options and scenes of `cargo xtask compare`]
#
# Run it from the repository's root, in a folder that all nodes see. A shard that is stopped goes on where it was when it
# is submitted again: the same command line does it.
set -eu

# Slurm runs this same file as the jobs, with the arguments as they were typed: none is quoted and unquoted on the way.
case ${1-} in
    --as-shard)
        xtask=$2 folder=$3 shards=$4
        shift 4
        exec "$xtask" compare --shard "$SLURM_ARRAY_TASK_ID/$shards" --out "$folder/shard-$SLURM_ARRAY_TASK_ID" "$@"
        ;;
    --as-merge)
        xtask=$2 folder=$3 shards=$4
        # These and no others: an earlier run may have left more of them.
        set --
        for k in $(seq "$shards"); do set -- "$@" "$folder/shard-$k"; done
        exec "$xtask" merge "$@" --out "$folder/report"
        ;;
esac

if [ $# -lt 2 ]; then
    sed -n '2,7s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
folder=$1
shards=$2
shift 2
case $shards in
    '' | 0* | *[!0-9]*)
        echo "SHARDS must be a whole number from 1 on, not \`$shards\`" >&2
        exit 2
        ;;
esac
mkdir -p "$folder"
# Built once, here, so that the tasks don't all wait for the first.
cargo build --profile measure --package xtask-measure
xtask="${CARGO_TARGET_DIR:-target}/measure/xtask-measure"
# Slurm would read a per cent sign as a field.
logs=$(printf '%s' "$folder" | sed 's/%/%%/g')

array=$(sbatch --parsable --job-name umbrage --array "1-$shards" --output "$logs/%a.log" --requeue \
    "$0" --as-shard "$xtask" "$folder" "$shards" "$@")
joined=$(sbatch --parsable --job-name umbrage-merge --dependency "afterok:$array" --output "$logs/merge.log" \
    "$0" --as-merge "$xtask" "$folder" "$shards")
echo "jobs $array ($shards shards) and $joined (merge); watch them with squeue; the report will be $folder/report/index.html"
