# numpy's BLAS wakes a second thread even for a 3x3 inverse, and that thread then keeps a whole core busy for 0.1 s.
# A graph is a dozen processes, so each keeps to one thread. Whoever wants more sets the variable.
export OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"
