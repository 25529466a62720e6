#!/bin/bash
# A sweep as a SLURM array job: 200 parts, each on one core, in one folder that all of them see.
#   sbatch scripts/sweep_slurm.sh configs/frequency_map.yaml
# Killed or timed-out parts are simply submitted again; what they finished is kept.  Afterwards, or at any moment:
#   warpdamp status results/frequency_map
#   warpdamp collect results/frequency_map
#SBATCH --job-name=warpdamp
#SBATCH --array=1-200
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=04:00:00
#SBATCH --signal=B:TERM@60
export OMP_NUM_THREADS=1
exec warpdamp run "${1:?name a configuration}" -o results --workers 1 --part "${SLURM_ARRAY_TASK_ID}/${SLURM_ARRAY_TASK_COUNT}"
