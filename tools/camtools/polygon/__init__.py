"""Kind "polygon": shafts of DIN 32711 and DIN 32712, and polygons with rounded corners."""
