"""OpenGL without any knowledge of headsets: context, shader loader, textures, timers."""
