// SystemC's library has a main function that calls this one. The programs have their own main.
extern "C" int sc_main(int /*argc*/, char** /*argv*/) { return 0; }
