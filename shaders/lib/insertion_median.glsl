// The median of up to MOST colours, channel by channel, by insertion: the list stays sorted.
// Source: none; insertion sort on vectors, so that all channels are sorted at once.
vec3 sorted[MOST];
int sorted_count = 0;

void insert(vec3 colour) {
    for (int place = 0; place < sorted_count; ++place) {
        vec3 low = min(sorted[place], colour);
        colour = max(sorted[place], colour);
        sorted[place] = low;
    }
    sorted[sorted_count++] = colour;
}

// The mean of the two middle ones (the same one if the count is odd); black of none.
vec3 middle_of_sorted() {
    return sorted_count == 0 ? vec3(0.0) : 0.5 * (sorted[(sorted_count - 1) / 2] + sorted[sorted_count / 2]);
}
