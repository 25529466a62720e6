"""A sweep on Dask: on a cluster started here, or on one whose scheduler's address is given.

python scripts/sweep_dask.py [CONFIG] [FOLDER] [tcp://scheduler:8786]

With dask-jobqueue the cluster may be a batch system's; its workers must see FOLDER:

    from dask_jobqueue import SLURMCluster
    cluster = SLURMCluster(cores=1, memory="2GB", walltime="04:00:00")
    cluster.scale(200)
    dataset = warpdamp.run(config, store=folder, executor=cluster.scheduler_address)
"""

import sys
from pathlib import Path

import warpdamp

if __name__ == "__main__":
    given = dict(enumerate(sys.argv[1:]))
    config, folder = given.get(0, "configs/design_study.yaml"), Path(given.get(1, "results/design_study"))
    executor = given.get(2, "dask")
    dataset = warpdamp.run(
        config, store=folder, executor=executor, report=lambda stage, done: print(f"{stage} {done:.0%}", flush=True)
    )
    print(dataset["effectiveness"])
