"""Analysis of ratings: tests, intervals, order effects, copied rows, published figures."""
