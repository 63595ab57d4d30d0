"""How a scene becomes a picture: shapes and looks to VTK, page and legend to matplotlib. No Qt."""
