// SystemC's library wants a function that its own main calls. The programs have their own main.
extern "C" int sc_main(int /*argc*/, char** /*argv*/) { return 0; }
