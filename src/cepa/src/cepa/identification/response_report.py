"""What `identify_response` tells: the figures, the lines for cepa.yaml, and a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cepa.identification.identify import COVERED, HORIZONS_S, MARGIN_M, Identification, predicted_velocities

MEASURED, MODELLED, COMMANDED = "#404040", "#cc1f1a", "#9ecae1"
SHOWN_S = 30.0


def report(found: Identification) -> str:
    """Return the figures of an identification, and the lines to paste into cepa.yaml."""
    model = found.model
    flown_s = sum(piece.times_s[-1] - piece.times_s[0] for piece in found.pieces)
    lines = [
        f"# Identified from {flown_s:.0f} s of flight; the model explains {found.explained:.0%} of the "
        "velocity's changes within 1 s.",
        f"# Predicted position against the measured one, {found.instants} times:",
        "#   after [s]     " + " ".join(f"{t:6.2f}" for t in HORIZONS_S),
        "#   RMS [m]       " + " ".join(f"{d:6.3f}" for d in found.deviation_rms_m),
        "#   greatest [m]  " + " ".join(f"{d:6.3f}" for d in found.deviation_max_m),
        f"# response_error covers {COVERED:.0%} of the predictions, with a margin of {MARGIN_M:g} m; "
        f"{found.error_max_m_s2:.2f} m/s2 would cover all.",
    ]
    if found.climb_lag_s is not None:
        lines.append(f"# The vertical velocity follows with a lag of {found.climb_lag_s:.2f} s.")
    lines += [
        f"response_p: {model.p:.3f}",
        f"response_i: {model.i:.3f}",
        f"response_d: {model.d:.3f}",
        f"response_lag: {model.lag_s:.3f}",
        f"response_delay: {model.delay_s:.3f}",
        f"response_acceleration_max: {model.acceleration_max_m_s2:.2f}  # the greatest that was flown",
        f"response_error: {model.error_m_s2:.2f}",
    ]
    return "\n".join(lines)


def draw(found: Identification, path: Path) -> None:
    """Write a picture of commanded, measured and modelled velocity, along both axes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    piece = max(found.pieces, key=lambda piece: len(piece.times_s))
    t = piece.times_s - piece.times_s[0]
    shown = t <= SHOWN_S
    modelled = predicted_velocities(piece, found.model)
    figure, axes = plt.subplots(2, 1, figsize=(10.0, 6.0), sharex=True, constrained_layout=True)
    for axis, plot in enumerate(axes):
        plot.plot(t[shown], piece.commands[shown, axis], color=COMMANDED, label="commanded")
        plot.plot(t[shown], piece.velocities[shown, axis], color=MEASURED, label="measured")
        plot.plot(t[shown], modelled[shown, axis], "--", color=MODELLED, label="modelled")
        plot.set_ylabel(f"velocity along {'xy'[axis]} [m/s]")
        plot.grid(alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncol=3, frameon=False)
    axes[1].set_xlabel("time [s]")
    error = np.sqrt(np.mean((modelled - piece.velocities[:, :2]) ** 2))
    axes[0].set_title(
        f"p {found.model.p:.2f}, i {found.model.i:.2f}, lag {found.model.lag_s:.3f} s, "
        f"delay {found.model.delay_s:.3f} s; "
        f"RMS {error:.2f} m/s without any correction"
    )
    figure.savefig(path, dpi=110)
    plt.close(figure)
