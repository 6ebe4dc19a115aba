"""CloudLight: light of moving lamps, and points of what it falls on, for clients that draw.

Each technique is one module: its layer, its part of the server, its pass on the client and its
strategy. The registries find them by entry_points.toml; nothing else imports this package.

Source: Crassin et al. 2013, CloudLight: A System for Amortizing Indirect Lighting in Real-Time
Rendering.
"""
