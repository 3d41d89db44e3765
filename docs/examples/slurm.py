"""A comparison on the nodes of a SLURM cluster: python slurm.py mine.toml out."""

import subprocess
import sys

from dask_jobqueue import SLURMCluster

if __name__ == "__main__":
    experiment, out = sys.argv[1:]
    with SLURMCluster(
        queue="standard",  # the name of your partition
        cores=16,
        processes=16,  # one thread each
        memory="16GB",
        walltime="04:00:00",
        job_script_prologue=["source ~/gyroctl/bin/activate"],  # the environment of the login node, on a shared disk
    ) as cluster:
        cluster.scale(jobs=8)
        command = [sys.executable, "-m", "gyroctl", "compare", experiment, "--out", out]
        sys.exit(subprocess.run([*command, "--scheduler", cluster.scheduler_address]).returncode)
