"""How the model that ships is made: shapes, views, simulated votes in several rounds, training; one command.

python -m eval.default_model WORK_DIR MESH_DIR -o default.safetensors
"""
