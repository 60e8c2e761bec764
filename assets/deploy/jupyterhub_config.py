"""Observer Lab for each student of a JupyterHub. The Littlest JupyterHub reads it from its folder `jupyterhub_config.d`.

Needs, where the students' servers run: `pip install ./observer_lab-*.whl jupyter-server-proxy`, in the environment that has jupyterlab.
The lab then has a tile in everybody's launcher and the address /user/NAME/observer-lab/; nothing below is needed for that.
"""

c = get_config()  # type: ignore[name-defined] # noqa: F821

c.Spawner.default_url = "/observer-lab/"  # whoever logs in is in the lab; without this line, in JupyterLab beside its tile
c.Spawner.environment = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # small matrices; the cores are for other students
c.Spawner.mem_limit = "600M"  # a student's Jupyter server with the lab; heeded by spawners that can
c.Spawner.cpu_limit = 1.0
c.Spawner.http_timeout = 60  # s: a whole course logs in at once
c.JupyterHub.concurrent_spawn_limit = 20
