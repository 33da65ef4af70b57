"""Where on a map does a set of points fit? A search over every place and heading.

    field = LikelihoodField.from_grid(grid)  # an OccupancyGrid: once for each map
    places = PlaceSearch(field).find(points_xy_m, SearchSettings())
    places[0].pose, places[0].score, places[0].covariance; places[1:] are its rivals

See `PlaceSearch` for the method.
"""

from gridslam.search.field import LikelihoodField
from gridslam.search.place_search import Place, PlaceSearch, SearchSettings, Window

__all__ = ["LikelihoodField", "Place", "PlaceSearch", "SearchSettings", "Window"]
