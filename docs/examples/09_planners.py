# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""Planners side by side: what the first plan costs, and what is proven."""

# %%
import gm_ompl

scenario = gm_ompl.load("paper/regrasp", {"fingers.placements.grid": [5, 5]})
best = gm_ompl.plan(scenario)
print(f"astar: {best.cost:.4g}, proven optimal: {best.optimal}")

# %%
for name in ("HybridRRT", "HybridRRTConnect", "HybridRRTstar", "RRTConnect"):
    costs = []
    for seed in range(3):
        plan = gm_ompl.plan(scenario, name, seed=seed, max_iterations=400)
        costs.append("-" if plan.cost is None else f"{plan.cost / best.cost:.2f}")
    print(f"{name}: times the optimum {', '.join(costs)}")
