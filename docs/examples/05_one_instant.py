# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""Judge one instant: geometry, the best control modes, the margin z."""

# %%
import gm_ompl

hand = [("-x", (3, 3)), ("+z", (5, 3))]  # one finger behind, one on top
verdict = gm_ompl.judge("paper/slide", [0.5], [1.0], hand)
print(verdict.finding.value)
decision = verdict.decision
print([mode.value for mode in decision.modes], decision.f_com, f"z = {decision.z:.3f}")

# %% The same hand cannot pull the box back.
print(gm_ompl.judge("paper/slide", [0.5], [-1.0], hand).finding.value)

# %% The finger on top, from the front edge to the back one.
for row in range(7):
    hand = [("-x", (3, 3)), ("+z", (row, 3))]
    print(row, f"{gm_ompl.judge('paper/slide', [0.5], [1.0], hand).decision.z:.3f}")
