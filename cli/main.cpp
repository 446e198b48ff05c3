#include "command_line.h"

int main(int argc, char** argv) { leave(run_command_line(argc, argv)); }
