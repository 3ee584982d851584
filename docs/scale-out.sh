#!/bin/sh
# Runs the comparison as a Slurm job array, one shard a task, and a job that merges the shards when all are done:
#
#   docs/scale-out.sh FOLDER SHARDS [options and scenes of `cargo xtask compare`]
#
# Run it in the repository's root, with a FOLDER that all nodes share. To continue interrupted shards, submit the same
# command line again.
set -eu

# Slurm runs this file for the jobs, too, and passes the arguments unchanged, without quoting.
case ${1-} in
    --as-shard)
        xtask=$2 folder=$3 shards=$4
        shift 4
        exec "$xtask" compare --shard "$SLURM_ARRAY_TASK_ID/$shards" --out "$folder/shard-$SLURM_ARRAY_TASK_ID" "$@"
        ;;
    --as-merge)
        xtask=$2 folder=$3 shards=$4
        # Only these: an earlier run may have left more folders.
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
# Build once, so that the tasks don't wait for each other.
cargo build --profile measure --package xtask-measure
xtask="${CARGO_TARGET_DIR:-target}/measure/xtask-measure"
# Escape per cent signs, which Slurm would expand.
logs=$(printf '%s' "$folder" | sed 's/%/%%/g')

array=$(sbatch --parsable --job-name umbrage --array "1-$shards" --output "$logs/%a.log" --requeue \
    "$0" --as-shard "$xtask" "$folder" "$shards" "$@")
joined=$(sbatch --parsable --job-name umbrage-merge --dependency "afterok:$array" --output "$logs/merge.log" \
    "$0" --as-merge "$xtask" "$folder" "$shards")
echo "jobs $array ($shards shards) and $joined (merge); watch them with squeue; the report will be $folder/report/index.html"
