"""CEPA that knows what it flies: candidates rolled through the UAV's response, memory, cost-to-go.

Read in this order, with doc/dynamic.md beside it:

1. ``dynamic.py``: one step, with the numbers of the page's list.
2. ``knowledge.py``: the values that go from step to step, and the one interface of what is known.
   ``plane_knowledge.py`` and ``space_knowledge.py`` are its two kinds.
3. ``candidates.py``, ``rollouts.py``, ``cost.py``, ``ways_out``: which velocities are tried, which are
   admissible, what they cost, and when the UAV leaves instead.
4. The rooms: ``obstacle_tracks`` (what moves), ``free_space`` (what was seen free), ``remembered`` (points
   of obstacles), ``cost_to_go`` (ways out). Each has its compiled loops in its own ``kernels``; those of
   paths and distance fields are in ``kernels`` here.

To change the cost: ``cost.py`` weighs what ``kernels/rollout.py`` measures along a path; the weights are in
``constants/choice.py``. To change a distance to keep: ``rollouts.py``. Every number is in ``constants``.
Words: the reference is the velocity that is asked for; a mover is a disc that holds an obstacle track that
moves; a way is a path through the cost-to-go.
"""
