// No body anywhere: clears an integer picture by drawing.
// In: nothing. Out: 0, the number of static things.
// Source: OpenGL 4.3 core specification, 17.4.3: clearing integer pictures by a colour is
// undefined.
layout(location = 0) out uint moves;

void main() {
    moves = 0u;
}
