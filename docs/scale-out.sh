#!/bin/sh
# The comparison as a Slurm job array, a shard a task, and a job that joins the shards when all are done:
#
#   docs/scale-out.sh FOLDER SHARDS [options and scenes of `cargo xtask compare`]
#
# Run it from the repository's root, in a folder that all nodes see. A shard that is stopped goes on where it was when it
# is submitted again: the same command line does it.
set -eu
if [ $# -lt 2 ]; then
    sed -n '2,7s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
folder=$1
shards=$2
shift 2
mkdir -p "$folder"
# Built once, here, so that the tasks don't all wait for the first.
cargo build --release --package xtask --features measure
xtask="${CARGO_TARGET_DIR:-target}/release/xtask"

array=$(sbatch --parsable --job-name umbrage --array "1-$shards" --output "$folder/%a.log" --requeue <<SCRIPT
#!/bin/sh
exec "$xtask" compare --shard "\$SLURM_ARRAY_TASK_ID/$shards" --out "$folder/shard-\$SLURM_ARRAY_TASK_ID" $*
SCRIPT
)
joined=$(sbatch --parsable --job-name umbrage-merge --dependency "afterok:$array" --output "$folder/merge.log" <<SCRIPT
#!/bin/sh
exec "$xtask" merge "$folder"/shard-* --out "$folder/report"
SCRIPT
)
echo "jobs $array ($shards shards) and $joined (merge); watch them with squeue; the report will be $folder/report/index.html"
