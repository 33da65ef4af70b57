"""From messages to velocities: pairing, freshness, levelling, jumps, braking and climb."""
