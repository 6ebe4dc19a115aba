"""What gives frames: the server that renders a scene, recorded sequences, a remote renderer."""
